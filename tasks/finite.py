"""A task as a finite deterministic model: exactly, or a lattice of its states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True, eq=False)
class FiniteModel:
    """A deterministic model of n states and k actions.

    observations  [n, d]  what the environment shows in each state
    successor     int64 [n, k]  the state after each action
    initial       int64 [m]  the states that an episode begins in, equally likely
    actions       [k, …]  the environment's action behind each column of `successor`
    exact         whether the model is the environment itself; if not, every path of the model is
                  also one of the environment, so that what it reaches is a lower bound
    how           in words, for the reader of a result
    """

    observations: npt.NDArray[np.generic]
    successor: npt.NDArray[np.int64]
    initial: npt.NDArray[np.int64]
    actions: npt.NDArray[np.generic]
    exact: bool
    how: str


def finite_model(env: object) -> FiniteModel | None:
    """The finite model that an environment (single or batched, wrapped or not) publishes, or None.

    An environment publishes one by a method `finite_model()` on its unwrapped form, which may
    return None. Raises TypeError if what it publishes is something else.
    """
    bare = getattr(env, "unwrapped", env)
    publish = getattr(bare, "finite_model", None)
    if publish is None:
        return None
    model = publish()
    if model is None:
        return None
    if not isinstance(model, FiniteModel):
        raise TypeError(f"{bare!r} publishes {type(model).__name__} as its finite model")
    return model
