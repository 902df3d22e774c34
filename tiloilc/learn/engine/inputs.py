"""What the networks see of (s, b): scaled observations and the automaton state as one-hot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.product import Floats, Int

if TYPE_CHECKING:
    from gymnasium.spaces import Space


class Inputs:
    """Turns s and b into the networks' input, on the learning device or in numpy.

    Observations are scaled by their bounds, or by their spread in states that were `shown` [n, d].
    `code` [states] names the state that stands for b.
    """

    def __init__(self, space: Space[Any], shown: Floats, code: Tensor, states: int) -> None:
        self.states, self.code = states, code
        middle, half = _scale(space, shown)
        self.middle, self.half = (torch.from_numpy(a).to(code.device) for a in (middle, half))
        self._middle, self._half = middle, half
        self._told = np.eye(states, dtype=np.float32)[code.cpu().numpy()]

    def __call__(self, observation: Tensor, state: Tensor) -> Tensor:
        """s [seed, n, d] and b [seed, n] to [seed, n, d + states]."""
        told = torch.nn.functional.one_hot(self.code[state], self.states)
        return torch.cat([(observation - self.middle) / self.half, told.to(observation)], dim=-1)

    def on_host(self, observations: Floats, states: Int) -> Floats:
        """The same in numpy, for acting."""
        scaled = (observations - self._middle) / self._half
        return np.concatenate([scaled, self._told[states]], axis=-1)


def _scale(space: Space[Any], shown: Floats) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Middle and half-width of each observation."""
    d = shown.shape[1]
    low, high = getattr(space, "low", None), getattr(space, "high", None)
    if low is None or high is None:
        low, high = np.full(d, -np.inf), np.full(d, np.inf)
    low, high = low.reshape(-1), high.reshape(-1)
    bounded = np.isfinite(low) & np.isfinite(high) & (high - low < 1e6)
    seen = shown if len(shown) else np.zeros((1, d), np.float32)
    with np.errstate(invalid="ignore", over="ignore"):
        middle = np.where(bounded, (low + high) / 2, seen.mean(0))
        half = np.where(bounded, (high - low) / 2, seen.std(0))
    half = np.where(half > 1e-6, half, 1.0)
    return middle.astype(np.float32), half.astype(np.float32)
