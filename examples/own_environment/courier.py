"""A courier on a 6×6 street grid: an ordinary Gymnasium environment, nothing of logic in it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.spaces import Discrete, MultiDiscrete

if TYPE_CHECKING:
    from tiloilc.tasks import MarkovModel

SIZE = 6
MOVES = ((0, 0), (1, 0), (0, 1), (-1, 0), (0, -1))


class Courier(gymnasium.Env[np.ndarray, int]):
    """The state is the corner (x, y) where the courier stands; it starts at a random one in y = 0.

    Actions: stay, east, north, west, south. A move off the grid does nothing. No rewards, no end:
    what is to be done, and for how long, the task file says.
    """

    observation_fields: ClassVar[dict[str, int]] = {"x": 0, "y": 1}

    def __init__(self) -> None:
        self.observation_space = MultiDiscrete([SIZE, SIZE])
        self.action_space = Discrete(len(MOVES))
        self.corner = np.zeros(2, dtype=np.int64)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.corner = np.array([self.np_random.integers(SIZE), 0])
        return self.corner.copy(), {}

    def step(self, action: int) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        self.corner = np.clip(self.corner + MOVES[int(action)], 0, SIZE - 1)
        return self.corner.copy(), 0.0, False, False, {}

    def markov_model(self) -> MarkovModel:
        """All corners, and what each move leads to: what `tiloilc verify` computes with."""
        from tiloilc.tasks import MarkovModel

        corners = np.array([(x, y) for x in range(SIZE) for y in range(SIZE)])
        after = np.clip(corners[:, None] + MOVES, 0, SIZE - 1)
        return MarkovModel(
            observations=corners,
            successor=(after[..., :1] * SIZE + after[..., 1:]),
            probability=np.ones((len(corners), len(MOVES), 1)),
            initial=(corners[:, 1] == 0) / SIZE,
            actions=np.arange(len(MOVES)),
            exact=True,
            how="all corners",
        )


gymnasium.register("Courier-v0", entry_point=Courier)
