"""Whether a task has a finite model of its environment, and whether that is true."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate.verify.chain import MAX_PAIRS
from tiloilc.foreign import blamed
from tiloilc.plan import Plan
from tiloilc.product import single

if TYPE_CHECKING:
    import gymnasium

    from tiloilc.tasks import MarkovModel

MAX_OUTCOMES = 1_000_000
"""Outcomes of a model beyond which it is left out; Storm is asked about them one by one."""

ROUNDING = 1e-6
"""By which a sum of probabilities may miss 1."""

TRIED = 5, 200
"""Episodes, and steps of each, in which a model is compared with its environment."""


def model_of(plan: Plan) -> tuple[MarkovModel | None, str]:
    """The model that the environment of `plan` publishes, and why it is not exact; empty if it is.

    An exact model is compared with the environment in a few random episodes. Raises CompileError
    RUN714 if it is no model, lacks actions or says that what happens there is impossible, RUN707 if
    the environment fails.
    """
    from tiloilc.tasks import markov_model

    env, name = single(plan.environment), plan.environment.id
    try:
        try:
            model = markov_model(env)
        except Exception as error:  # an environment is anyone's code
            raise _wrong(name, f"{type(error).__name__}: {error}") from error
        if model is not None and (fault := _fault(model)):
            raise _wrong(name, fault)
        if model is None:
            return None, f"`{name}` publishes no finite model of itself"
        if model.successor.size > MAX_OUTCOMES:
            problem = f"its model has {model.successor.size:,} outcomes, more than {MAX_OUTCOMES:,}"
            return None, problem
        if not model.exact:
            return model, f"the finite model of `{name}` is not exact"
        if not _has_all_actions(model, env.action_space):
            raise _wrong(name, f"`actions` are not those of its action space, {env.action_space}")
        pairs = len(model.initial) * len(plan.ldba.names)
        if pairs > MAX_PAIRS:
            return model, f"there are {pairs:,} pairs of states, more than {MAX_PAIRS:,}"
        _compare(env, model, name)
        return model, ""
    finally:
        env.close()


def _has_all_actions(model: MarkovModel, space: gymnasium.Space[Any]) -> bool:
    """Whether an agent in `space` can only do what the model knows."""
    from gymnasium.spaces import Discrete

    actions = np.asarray(model.actions)
    return isinstance(space, Discrete) and np.array_equal(
        np.unique(actions), np.arange(space.start, space.start + space.n)
    )


def _compare(env: gymnasium.Env[Any, Any], model: MarkovModel, name: str) -> None:
    """Random episodes: each step must be one that the model thinks possible, and an end an end."""
    rng = np.random.default_rng(0)
    shown = model.seen
    actions = np.asarray(model.actions)
    for episode in range(TRIED[0]):
        with blamed(name, "reset() fails", __file__):
            observation, over = env.reset(seed=episode)[0], False
        here = np.flatnonzero((model.initial > 0) & _like(shown, observation))
        for step in range(TRIED[1] + 1):
            when = f"step {step} of an episode" if step else "the start of an episode"
            if not len(here):
                seen = np.asarray(observation).tolist()
                raise _wrong(name, f"{when} shows {seen}, which is none of its states then")
            if over:
                if not _is_never_left(model, here):
                    raise _wrong(name, f"{when} ends it, and there the model goes on")
                break
            column = int(rng.integers(len(actions)))
            with blamed(name, "step() fails", __file__):
                observation, _, over, _, _ = env.step(actions[column])
            after = model.successor[here, column][model.probability[here, column] > 0]
            here = np.unique(after[_like(shown[after], observation)])


def _is_never_left(model: MarkovModel, states: NDArray[np.int64]) -> bool:
    """Whether one of `states` only leads to itself: an episode that ends stays where it is."""
    stays = (model.successor[states] == states[:, None, None]) | (model.probability[states] == 0)
    return bool(stays.all(axis=(1, 2)).any())


def _fault(model: MarkovModel) -> str:
    """What is wrong with a model on its own, empty if nothing is."""
    shape = model.successor.shape
    if len(shape) != 3 or model.probability.shape != shape:
        return "`successor` and `probability` are not both [state, action, outcome]"
    if not len(model.observations) == len(model.initial) == shape[0]:
        return f"`observations` and `initial` are not of {shape[0]} states, as `successor` is"
    if len(model.actions) != shape[1]:
        return f"`actions` are not {shape[1]}, as `successor` has them"
    if (model.successor < 0).any() or (model.successor >= shape[0]).any():
        return f"`successor` leads out of the states 0 to {shape[0] - 1}"
    for chances, named in ((model.probability, "probability"), (model.initial, "initial")):
        sums = chances.sum(axis=-1)
        if (chances < 0).any() or not (abs(sums - 1) <= ROUNDING).all():  # nan is no chance
            return f"`{named}` has probabilities that do not sum to 1"
    return ""


def _wrong(name: str, problem: str) -> CompileError:
    return CompileError(Diagnostic.of("RUN714", id=name, problem=problem))


def _like(shown: NDArray[np.float32], observation: object) -> NDArray[np.bool_]:
    """Which rows of `shown` [n, d] are this observation."""
    flat = np.asarray(observation, np.float32).reshape(-1)
    if flat.shape != shown.shape[1:]:
        return np.zeros(len(shown), np.bool_)
    return np.asarray((shown == flat).all(axis=1), np.bool_)
