"""The best that any policy can do in a finite model, by exact backward induction.

The product of the model and the automaton is walked backwards from the horizon: with h steps left,

    V_h(s, b) = max over actions a of W_h(s'),   s' = successor(s, a),
    W_h(s')   = max over b' in options(b, L(s')) of [b' accepting] + V_{h-1}(s', b'),

so ε-jumps are chosen as well as actions can choose them. Where jumps take a step, b' = δ(b, L(s'))
with h − 1 steps left may also go on to each jump target c, for [c accepting] + V_{h-2}(s', c).
What is counted is what the evaluation counts: accepting automaton states arrived in at steps 1 to
T. The state after the first label is none of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from tiloilc.automaton.ldba import Ldba
from tiloilc.product.walk import walk_tables
from tiloilc.spec.settings import Epsilon

if TYPE_CHECKING:
    from tiloilc.tasks import FiniteModel, Known

Int: TypeAlias = npt.NDArray[np.int64]
Value: TypeAlias = npt.NDArray[np.int32]
Labels: TypeAlias = Callable[[npt.NDArray[np.float32]], Int]

MAX_WORK = 4_000_000_000
"""Table entries looked at in one induction, about a minute's worth; more is not attempted."""


@dataclass(frozen=True, slots=True)
class Optimum:
    """The greatest mean number of accepting visits in an episode.

    `exact`: no policy can do better; otherwise the value is a bound, and `how` says which.
    """

    accepting_visits: float
    exact: bool
    how: str


@dataclass(frozen=True, slots=True, eq=False)
class BestEpisode:
    """One episode that reaches the optimum: model states [T+1], action columns [T], and the
    automaton states [T+1], the first after the first label.
    """

    model_states: Int
    actions: Int
    automaton_states: Int


def optimum(
    model: FiniteModel, letters: Int, ldba: Ldba, horizon: int, epsilon: Epsilon = "free"
) -> Optimum:
    """The optimum of `model`, whose state s is labelled `letters[s]`, in `horizon` steps."""
    walk = walk_tables(ldba, epsilon)
    options, accepting = walk.options[:, letters], _accepting(ldba)
    value = np.zeros((len(letters), len(ldba.states)), np.int32)
    later = value - 1 - accepting.max(initial=0)  # with no step left nobody jumps
    for _ in range(horizon):
        arrival = _arrival(value, options, accepting, later if walk.costly else None)
        value, later = _backward(model, arrival), value
    start, first = model.initial[:, None], options[ldba.initial, model.initial]
    best = value[start, first].max(axis=1)
    if walk.costly:
        jumped = (later + accepting)[start, first].max(axis=1)
        best = np.maximum(value[start, first[:, :1]][:, 0], jumped)
    return Optimum(float(best.mean()), model.exact, model.how)


def best_episode(
    model: FiniteModel, letters: Int, ldba: Ldba, horizon: int, start: int = 0
) -> BestEpisode:
    """An episode from the model's initial state number `start` that reaches its optimum."""
    options = _options(ldba, letters)
    accepting = _accepting(ldba)
    values = [np.zeros((len(letters), len(ldba.states)), np.int32)]
    for _ in range(horizon):
        values.append(_backward(model, _arrival(values[-1], options, accepting)))
    s = int(model.initial[start])
    first = options[ldba.initial, s]
    b = int(first[values[horizon][s, first].argmax()])
    path, actions, run = [s], [], [b]
    for left in range(horizon - 1, -1, -1):
        reached = model.successor[s]
        choice = options[b, reached]
        worth = accepting[choice] + values[left][reached[:, None], choice]
        action, jump = np.unravel_index(int(worth.argmax()), worth.shape)
        s, b = int(reached[action]), int(choice[action, jump])
        path.append(s)
        actions.append(int(action))
        run.append(b)
    return BestEpisode(np.array(path), np.array(actions, np.int64), np.array(run))


def task_optimum(
    environment: str,
    kwargs: Mapping[str, Any],
    labels: Labels,
    ldba: Ldba,
    horizon: int,
    epsilon: Epsilon = "free",
) -> Optimum | None:
    """The optimum of an environment that publishes a finite model, or the best that it knows.

    None if it publishes neither; a model is left out if the induction would look at more than
    MAX_WORK entries.
    """
    import gymnasium

    from tiloilc.tasks import finite_model, known_best

    env = gymnasium.make(environment, disable_env_checker=True, **kwargs)
    model = finite_model(env)
    if model is not None and model.successor.size * len(ldba.states) * horizon <= MAX_WORK:
        env.close()
        observations = model.observations.astype(np.float32)
        return optimum(model, labels(observations), ldba, horizon, epsilon)
    known = [_achieved(best, labels, ldba, epsilon) for best in known_best(env, horizon)]
    env.close()
    return max(known, key=lambda found: found.accepting_visits, default=None)


def _achieved(known: Known, labels: Labels, ldba: Ldba, epsilon: Epsilon) -> Optimum:
    """What episodes that are known achieve, with jumps chosen as well as they can be.

    Each is a finite model without any choice but that of jumps.
    """
    from tiloilc.tasks import FiniteModel

    visits = []
    for observations in known.observations.astype(np.float32):
        steps = np.arange(len(observations))
        alone = FiniteModel(
            observations, np.append(steps[1:], steps[-1])[:, None], steps[:1], steps[:1], False, ""
        )
        found = optimum(alone, labels(observations), ldba, len(steps) - 1, epsilon)
        visits.append(found.accepting_visits)
    return Optimum(float(np.mean(visits)), False, known.how)


def _options(ldba: Ldba, letters: Int) -> Int:
    """Where one may go from automaton state b on arriving in s, [B, n, K]."""
    return walk_tables(ldba).options[:, letters]


def _accepting(ldba: Ldba) -> Value:
    """1 for accepting automaton states, [B]."""
    return np.array([b in ldba.accepting for b in ldba.states], np.int32)


def _arrival(value: Value, options: Int, accepting: Value, later: Value | None = None) -> Value:
    """W: the worth of arriving in s while in b, [n, B], from the worth of being there, [n, B].

    `later` is the worth of being there with one step less, where jumps take one.
    """
    state = np.arange(len(value))[:, None]
    worth = value + accepting
    if later is None:
        return np.stack([worth[state, row].max(axis=1) for row in options], axis=1)
    jumped = later + accepting
    best = [
        np.maximum(worth[state, row[:, :1]][:, 0], jumped[state, row].max(axis=1))
        for row in options
    ]
    return np.stack(best, axis=1)


def _backward(model: FiniteModel, arrival: Value) -> Value:
    """V: the best that any action reaches, [n, B]."""
    best = arrival[model.successor[:, 0]]
    for action in range(1, model.successor.shape[1]):
        np.maximum(best, arrival[model.successor[:, action]], out=best)
    return best
