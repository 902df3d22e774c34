"""The observations of a finite environment, numbered."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.product import Int

if TYPE_CHECKING:
    from gymnasium.spaces import Space


@dataclass(frozen=True, slots=True)
class Cells:
    """`count` cells: component i of an observation has `sizes[i]` values from `low[i]` on, [d]."""

    low: Int
    sizes: Int
    strides: Int
    count: int

    @classmethod
    def of(cls, space: Space[Any]) -> Cells:
        """The cells of a finite observation space."""
        low, sizes = _extent(space)
        strides = [int(sizes[i + 1 :].prod()) for i in range(len(sizes))]
        return cls(low, sizes, np.array(strides), int(sizes.prod()))

    def __call__(self, observations: NDArray[Any]) -> Int:
        """The number of each observation [..., d] among all cells."""
        number: Int = (observations.astype(np.int64) - self.low) @ self.strides
        return number


def _extent(space: Space[Any]) -> tuple[Int, Int]:
    """The least value of each observed number, and how many values it has."""
    from gymnasium import spaces

    if isinstance(space, spaces.Discrete):
        return np.array([space.start]), np.array([space.n])
    if isinstance(space, spaces.MultiDiscrete):
        return space.start.reshape(-1).astype(np.int64), space.nvec.reshape(-1).astype(np.int64)
    if isinstance(space, spaces.MultiBinary):
        return np.zeros(space.shape, np.int64).reshape(-1), np.full(prod(space.shape), 2)
    assert isinstance(space, spaces.Box)
    low = space.low.reshape(-1).astype(np.int64)
    return low, space.high.reshape(-1).astype(np.int64) - low + 1
