"""Small environments for the tests of everything that steps environments."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary
from numpy.typing import NDArray

Observation = NDArray[Any]


class Line(gym.Env[Observation, int]):
    """Cells 0 to size-1 in a row; actions left, stay, right. It may end at its last cell."""

    def __init__(self, size: int = 5, ends: bool = False, start: int | None = 0) -> None:
        self.observation_space = Box(0, size - 1, (1,), np.int64)
        self.action_space = Discrete(3)
        self.size, self.ends, self.start = size, ends, start
        self.place, self.over = 0, True

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        drawn = int(self.np_random.integers(self.size))
        self.place, self.over = drawn if self.start is None else self.start, False
        return np.array([self.place]), {}

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        assert not self.over, "stepped past its end"
        assert self.action_space.contains(action)
        self.place = int(np.clip(self.place + int(action) - 1, 0, self.size - 1))
        self.over = self.ends and self.place == self.size - 1
        return np.array([self.place]), 0.0, self.over, False, {}


class Drift(gym.Env[Observation, Observation]):
    """A point on a line with noise of its own; actions in [-2, 4]. It may end beyond 1."""

    def __init__(self, ends: bool = False) -> None:
        self.observation_space = Box(-np.inf, np.inf, (2,), np.float32)
        self.action_space = Box(np.float32(-2), np.float32(4), (1,), np.float32)
        self.ends, self.over = ends, True
        self.state = np.zeros(2, np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self.state, self.over = self.np_random.normal(size=2).astype(np.float32) / 4, False
        return self.state.copy(), {}

    def step(self, action: Observation) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        assert not self.over, "stepped past its end"
        assert self.action_space.contains(action)
        noise = self.np_random.normal(size=2).astype(np.float32) / 20
        self.state = self.state + noise + np.float32(0.1) * action
        self.over = self.ends and bool(self.state[0] > 1)
        return self.state.copy(), 0.0, self.over, False, {}


class Parts(gym.Env[dict[str, Observation], int]):
    """A Dict observation: what `flatten` makes of it is [near(2), switch(3, one-hot)]."""

    observation_space = Dict({"near": Box(-1, 1, (2,)), "switch": Discrete(3)})
    action_space = Discrete(2)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        super().reset(seed=seed)
        return {"near": np.array([0.5, -0.5], np.float32), "switch": 1}, {}

    def step(self, action: int) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        return {"near": np.zeros(2, np.float32), "switch": 2}, 0.0, False, False, {}


class Switches(gym.Env[Observation, int]):
    """Three switches; action i turns switch i."""

    observation_space = MultiBinary(3)
    action_space = Discrete(3)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self.on = np.zeros(3, np.int8)
        return self.on.copy(), {}

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self.on[action] ^= 1
        return self.on.copy(), 0.0, False, False, {}


class Forgetful(Drift):
    """Ignores its seeds: no two episodes are alike."""

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        return super().reset(seed=None, options=options)


for _world in (Line, Drift, Parts, Switches, Forgetful):
    _name = f"Tests{_world.__name__}-v0"
    if _name not in gym.registry:
        gym.register(_name, entry_point=_world)
gym.registry.setdefault(
    "TestsShort-v0",
    gym.envs.registration.EnvSpec("TestsShort-v0", entry_point=Line, max_episode_steps=3),
)
