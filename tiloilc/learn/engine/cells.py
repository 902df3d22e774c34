"""The observations of a finite environment, numbered."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

if TYPE_CHECKING:
    from gymnasium.spaces import Space


@dataclass(frozen=True, slots=True)
class Cells:
    """A cell for each observation: component i has `sizes[i]` values from `low[i]` on, both [d]."""

    low: Tensor
    sizes: Tensor
    strides: Tensor

    @classmethod
    def of(cls, space: Space[Any]) -> Cells:
        """The cells of a finite observation space."""
        low, sizes = (torch.from_numpy(array) for array in _extent(space))
        strides = torch.tensor([int(sizes[i + 1 :].prod()) for i in range(len(sizes))])
        return cls(low, sizes, strides)

    @property
    def count(self) -> int:
        """How many cells there are."""
        return int(self.sizes.prod())

    def __call__(self, observations: Tensor) -> Tensor:
        """The number of each observation [..., d] among all cells."""
        return ((observations.long() - self.low) * self.strides).sum(-1)


def _extent(space: Space[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
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
