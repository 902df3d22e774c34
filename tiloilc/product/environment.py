"""Many copies of one Gymnasium environment behind one batched interface."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.spec.model import Environment

if TYPE_CHECKING:
    import gymnasium as gym
    from gymnasium.vector import VectorEnv

Floats = NDArray[np.float32]


class Copies:
    """`count` copies of an environment: flat float32 observations [n, d], no automatic reset.

    Built on Gymnasium's vector interface with autoreset disabled; an environment that registers a
    `vector_entry_point` is stepped as one array program, any other one by one.
    """

    def __init__(self, environment: Environment, count: int) -> None:
        import gymnasium as gym
        from gymnasium.vector import AutoresetMode

        name = _import_module_of(environment.id)
        batched = gym.spec(name).vector_entry_point is not None
        extra: dict[str, Any] = (
            {} if batched else {"vector_kwargs": {"autoreset_mode": AutoresetMode.DISABLED}}
        )
        self.vector: VectorEnv[Any, Any, Any] = gym.make_vec(
            name,
            num_envs=count,
            vectorization_mode="vector_entry_point" if batched else "sync",
            **extra,
            **environment.kwargs,
        )
        if self.vector.metadata.get("autoreset_mode") != AutoresetMode.DISABLED:
            raise CompileError(Diagnostic.of("JOB607", id=environment.id))
        self.count = count
        self.observation_space: gym.Space[Any] = self.vector.single_observation_space
        self.action_space: gym.Space[Any] = self.vector.single_action_space
        self.finite = is_finite(self.observation_space, self.action_space)
        self.dimensions = (
            gym.spaces.flatdim(self.observation_space)
            if not self.finite
            else (int(np.prod(self.observation_space.shape or (1,))))
        )

    def reset(self, seeds: Sequence[int], mask: NDArray[np.bool_]) -> Floats:
        """Begin an episode in the copies of `mask`; `seeds` has one entry for each copy."""
        observations, _ = self.vector.reset(
            seed=list(seeds),  # type: ignore[arg-type]  # all vector environments take a list
            options={"reset_mask": mask},
        )
        return self._flat(observations)

    def step(self, actions: NDArray[Any]) -> tuple[Floats, NDArray[np.bool_]]:
        """Step all copies: observations [n, d] and who has terminated [n]."""
        observations, _, terminated, _, _ = self.vector.step(actions)
        return self._flat(observations), np.asarray(terminated, dtype=np.bool_)

    def close(self) -> None:
        """Give the environments back."""
        self.vector.close()

    def _flat(self, observations: Any) -> Floats:
        if isinstance(observations, dict):
            from gymnasium.spaces.utils import flatten

            singles = [{k: v[i] for k, v in observations.items()} for i in range(self.count)]
            rows = [flatten(self.observation_space, single) for single in singles]
            return np.asarray(rows, dtype=np.float32)
        return np.array(observations, dtype=np.float32).reshape(self.count, -1)


def is_finite(observation_space: gym.Space[Any], action_space: gym.Space[Any]) -> bool:
    """Whether both spaces are finite, so that values fit a table."""
    from gymnasium import spaces

    whole = isinstance(observation_space, spaces.Discrete | spaces.MultiDiscrete) or (
        isinstance(observation_space, spaces.Box)
        and np.issubdtype(observation_space.dtype, np.integer)
    )
    return whole and isinstance(action_space, spaces.Discrete)


def _import_module_of(name: str) -> str:
    """Import what registers `name`: the part before a colon, or the project's own tasks."""
    module, _, rest = name.rpartition(":")
    if module:
        importlib.import_module(module)
    elif name.startswith("tiloilc/"):
        importlib.import_module("tiloilc.tasks")
    return rest
