"""Whether a task has a finite model of its environment, and whether that is true."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate.verify.chain import MAX_PAIRS
from tiloilc.plan import Plan
from tiloilc.product import single

if TYPE_CHECKING:
    import gymnasium

    from tiloilc.tasks import MarkovModel

MAX_OUTCOMES = 1_000_000
"""Outcomes of a model beyond which it is left out; Storm is asked about them one by one."""

TRIED = 5, 200
"""Episodes, and steps of each, in which a model is compared with its environment."""


def model_of(plan: Plan) -> tuple[MarkovModel | None, str]:
    """The model that the environment of `plan` publishes, and why it is not exact; empty if it is.

    An exact model is compared with the environment in a few random episodes. Raises CompileError
    RUN714 if it says that what happens there is impossible, RUN707 if the environment fails.
    """
    from tiloilc.tasks import markov_model

    env = single(plan.environment)
    try:
        model = markov_model(env)
        if model is None:
            return None, f"`{plan.environment.id}` publishes no finite model of itself"
        if model.successor.size > MAX_OUTCOMES:
            problem = f"its model has {model.successor.size:,} outcomes, more than {MAX_OUTCOMES:,}"
            return None, problem
        if not model.exact:
            return model, f"the finite model of `{plan.environment.id}` is not exact"
        pairs = len(model.initial) * len(plan.ldba.names)
        if pairs > MAX_PAIRS:
            return model, f"there are {pairs:,} pairs of states, more than {MAX_PAIRS:,}"
        _compare(env, model, plan.environment.id)
        return model, ""
    finally:
        env.close()


def _compare(env: gymnasium.Env[Any, Any], model: MarkovModel, name: str) -> None:
    """Random episodes: each step must be one that the model thinks possible."""
    rng = np.random.default_rng(0)
    shown = np.asarray(model.observations, np.float32).reshape(len(model.observations), -1)
    actions = np.asarray(model.actions)
    for episode in range(TRIED[0]):
        observation, _ = env.reset(seed=episode)
        here = np.flatnonzero((model.initial > 0) & _like(shown, observation))
        for step in range(TRIED[1]):
            if not len(here):
                when = f"step {step} of an episode" if step else "the start of an episode"
                problem = f"{when} shows {np.asarray(observation).tolist()}, which is none of them"
                raise CompileError(Diagnostic.of("RUN714", id=name, problem=problem))
            column = int(rng.integers(len(actions)))
            observation, _, over, _, _ = env.step(actions[column])
            after = model.successor[here, column][model.probability[here, column] > 0]
            here = np.unique(after[_like(shown[after], observation)])
            if over:
                break


def _like(shown: NDArray[np.float32], observation: object) -> NDArray[np.bool_]:
    """Which rows of `shown` [n, d] are this observation."""
    flat = np.asarray(observation, np.float32).reshape(-1)
    if flat.shape != shown.shape[1:]:
        return np.zeros(len(shown), np.bool_)
    return np.asarray((shown == flat).all(axis=1), np.bool_)
