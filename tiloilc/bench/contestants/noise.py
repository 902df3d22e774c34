"""An environment of random numbers: what learning costs does not depend on what is learned."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

OBSERVATIONS, ACTIONS = 31, 4

STATES = 5
"""Of the task's automaton, which we are told as one-hot: others see as many numbers more."""


class Noise(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Observations of `size` normal numbers, whatever the four actions are."""

    def __init__(self, size: int = OBSERVATIONS) -> None:
        self.observation_space = Box(-np.inf, np.inf, (size,), np.float32)
        self.action_space = Box(-1.0, 1.0, (ACTIONS,), np.float32)
        self.observation_fields = {"x": slice(0, 4)}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode; no options are known."""
        super().reset(seed=seed)
        return self._look(), {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """One step, without reward or end."""
        return self._look(), 0.0, False, False, {}

    def _look(self) -> NDArray[np.float32]:
        shape = self.observation_space.shape
        assert shape is not None
        return self.np_random.standard_normal(shape).astype(np.float32)


gymnasium.register("TiloilcNoise-v0", entry_point=f"{__name__}:Noise")
