"""A task as a Markov decision process: what chance and the agent can make of each state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from tiloilc.tasks.finite import FiniteModel, finite_model

Outcome: TypeAlias = tuple[float, int, float, bool]
"""As in Gymnasium's `P[state][action]`: probability, next state, reward, whether it ends there."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkovModel:
    """n states, k actions in each, and at most m outcomes of an action.

    observations  [n, …]  what the environment shows in each state
    successor     int64 [n, k, m]  the states that an action may lead to
    probability   float64 [n, k, m]  how likely each is; they sum to 1, and 0 fills up
    initial       float64 [n]  how likely an episode begins in a state; they sum to 1
    actions       [k, …]  the environment's action behind each column
    exact         whether the model is the environment itself; if not, it is one of its paths only
    how           in words, for the reader of a result
    """

    observations: npt.NDArray[np.generic]
    successor: npt.NDArray[np.int64]
    probability: npt.NDArray[np.float64]
    initial: npt.NDArray[np.float64]
    actions: npt.NDArray[np.generic]
    exact: bool
    how: str

    @property
    def seen(self) -> npt.NDArray[np.float32]:
        """What predicates and policies get to see of each state: flat, float32 [n, d]."""
        return np.asarray(self.observations, np.float32).reshape(len(self.observations), -1)


def markov_model(env: object) -> MarkovModel | None:
    """The decision process that an environment publishes, or None.

    By a method `markov_model()` on its unwrapped form, by `finite_model()` if nothing in it is left
    to chance, or as Gymnasium's toy texts do, by `P[state][action]` and `initial_state_distrib`,
    where the state is what is observed. What ends an episode is a state that is never left. Raises
    TypeError if what is published is something else.
    """
    bare = getattr(env, "unwrapped", env)
    publish = getattr(bare, "markov_model", None)
    if publish is not None:
        model = publish()
        if model is not None and not isinstance(model, MarkovModel):
            raise TypeError(f"{bare!r} publishes {type(model).__name__} as its Markov model")
        return model
    finite = finite_model(env)
    if finite is not None:
        return without_chance(finite)
    table, starts = getattr(bare, "P", None), getattr(bare, "initial_state_distrib", None)
    space = getattr(env, "observation_space", None)
    if not isinstance(table, Mapping) or starts is None or getattr(space, "n", 0) != len(table):
        return None
    return _of_table(table, np.asarray(starts, np.float64))


def without_chance(model: FiniteModel) -> MarkovModel:
    """A deterministic model as a decision process; starts are equally likely."""
    initial = np.bincount(model.initial, minlength=len(model.observations)) / len(model.initial)
    return MarkovModel(
        model.observations,
        model.successor[..., None],
        np.ones((*model.successor.shape, 1)),
        initial,
        model.actions,
        model.exact,
        model.how,
    )


def _of_table(
    table: Mapping[int, Mapping[int, Sequence[Outcome]]], starts: npt.NDArray[np.float64]
) -> MarkovModel:
    """Gymnasium's table; each state that an episode ends in has a twin that is never left."""
    n, k = len(table), len(table[0])
    outcomes: Any = [[table[s][a] for a in range(k)] for s in range(n)]
    ends = sorted({int(o[1]) for row in outcomes for cell in row for o in cell if o[3]})
    twin = {s: n + i for i, s in enumerate(ends)}
    m = max(len(cell) for row in outcomes for cell in row)
    successor = np.zeros((n + len(ends), k, m), np.int64)
    probability = np.zeros(successor.shape)
    for s, row in enumerate(outcomes):
        for a, cell in enumerate(row):
            for i, (p, after, _, over) in enumerate(cell):
                successor[s, a, i] = twin[after] if over else after
                probability[s, a, i] = p
    successor[n:] = np.arange(n, n + len(ends))[:, None, None]
    probability[n:, :, 0] = 1.0
    return MarkovModel(
        np.array([*range(n), *ends])[:, None],
        successor,
        probability,
        np.concatenate([starts, np.zeros(len(ends))]),
        np.arange(k),
        True,
        f"all {n} states, as the environment's table of transitions has them",
    )
