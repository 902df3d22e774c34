"""Environments whose state is one array for all copies, and the single environment as a view."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.finite import FiniteModel
from tiloilc.tasks.known import Known
from tiloilc.tasks.scene import Pixels, Scene, rasterise

Array = npt.NDArray[Any]


class BatchedEnv(VectorEnv[Array, Array, Array]):
    """n copies of a task in step. A task says how it starts, moves and looks; all else is here.

    The convention is Gymnasium's `AutoresetMode.DISABLED`: copies run on until
    `reset(options={"reset_mask": bool[n]})` begins those anew that the mask names. There are no
    rewards, terminations or truncations. Copy i of `reset(seed=s)` is the single environment after
    `reset(seed=s + i)`, bit for bit; a sequence of n seeds gives each copy its own.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  # as Gymnasium declares it
        "render_modes": ["rgb_array"],
        "render_fps": 10,
        "autoreset_mode": AutoresetMode.DISABLED,
    }
    observation_fields: dict[str, slice | int]
    """Names of components of the observation."""

    def __init__(
        self,
        num_envs: int,
        observation_space: gymnasium.Space[Any],
        action_space: gymnasium.Space[Any],
        render_mode: str | None,
    ) -> None:
        if num_envs < 1:
            raise ValueError(f"num_envs must be at least 1, not {num_envs}")
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode must be 'rgb_array' or None, not {render_mode!r}")
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.single_observation_space = observation_space
        self.single_action_space = action_space
        self.observation_space = batch_space(observation_space, num_envs)
        self.action_space = batch_space(action_space, num_envs)
        self._generators: list[np.random.Generator | None] = [None] * num_envs
        self._seeds: list[int | None] = [None] * num_envs
        self._state: Array | None = None

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Array, dict[str, Any]]:
        """Begin all copies anew, or those of `options["reset_mask"]`; returns all observations.

        Raises ValueError or TypeError if the seeds or the mask do not fit the number of copies.
        """
        mask = self._mask(options)
        seeds = self._seed_list(seed)
        for i in np.flatnonzero(mask):
            if seeds[i] is not None:
                self._seeds[i], self._generators[i] = seeds[i], None
        if self._state is None:
            if not mask.all():
                raise ValueError("the first reset must be of all copies")
            self._state = self._start(np.arange(self.num_envs))
        else:
            state = self._state.copy()
            state[mask] = self._start(np.flatnonzero(mask))
            self._state = state
        return self._observe(self._state), {}

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """One step of all copies: observations [n, …], rewards, terminations, truncations [n]."""
        if self._state is None:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        self._state = self._move(self._state, np.asarray(actions))
        none = np.zeros(self.num_envs, np.bool_)
        return self._observe(self._state), np.zeros(self.num_envs), none, none.copy(), {}

    def render(self) -> tuple[Pixels, ...] | None:
        """One picture a copy, uint8 [256, w, 3]; None without render mode."""
        if self.render_mode is None:
            return None
        if self._state is None:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        scene = self.scene()
        seen = self._observe(self._state)[:, list(scene.position)]
        return tuple(rasterise(scene, place) for place in seen.astype(np.float64))

    def set_state(self, observations: Array) -> None:
        """Put all copies into the states that show `observations` [n, …]."""
        self._state = self._recover(np.asarray(observations))

    def generator(self, copy: int) -> np.random.Generator:
        """The random numbers of one copy."""
        generator = self._generators[copy]
        if generator is None:
            generator, _ = seeding.np_random(self._seeds[copy])
            self._generators[copy] = generator
        return generator

    def adopt(self, generator: np.random.Generator) -> None:
        """Let copy 0 draw from `generator`: how the single environment shares its own."""
        self._generators[0] = generator

    @abstractmethod
    def scene(self) -> Scene:
        """What there is to see."""

    @abstractmethod
    def experts(self) -> tuple[Expert, ...]:
        """Scripted experts, one for each task the world is used for."""

    def finite_model(self) -> FiniteModel | None:
        """The task as a finite deterministic model; None if that would say too little."""
        return None

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """The best episodes of `horizon` steps that are known; none where there is a model."""
        return ()

    @abstractmethod
    def _start(self, copies: npt.NDArray[np.int64]) -> Array:
        """Initial states [k, …] of the k copies named, drawn from their generators."""

    @abstractmethod
    def _move(self, state: Array, actions: Array) -> Array:
        """The states after `actions`, both [n, …]; a new array."""

    @abstractmethod
    def _observe(self, state: Array) -> Array:
        """What is seen in states [n, …], as a new array [n, d]."""

    @abstractmethod
    def _recover(self, observations: Array) -> Array:
        """The states behind observations [n, d]."""

    def _mask(self, options: dict[str, Any] | None) -> npt.NDArray[np.bool_]:
        mask = (options or {}).get("reset_mask")
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise TypeError("options['reset_mask'] must be a numpy array of booleans")
        if mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(
                f"options['reset_mask'] must have shape ({self.num_envs},) and name a copy"
            )
        return mask

    def _seed_list(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [int(seed) + i for i in range(self.num_envs)]
        seeds = [None if s is None else int(s) for s in seed]
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} copies")
        return seeds


class SingleEnv(gymnasium.Env[Array, Any]):
    """One copy of a batched task as an ordinary Gymnasium environment."""

    metadata: dict[str, Any] = {  # noqa: RUF012  # as Gymnasium declares it
        "render_modes": ["rgb_array"],
        "render_fps": 10,
    }

    def __init__(self, batched: BatchedEnv) -> None:
        self.batched = batched
        self.render_mode = batched.render_mode
        self.observation_space = batched.single_observation_space
        self.action_space = batched.single_action_space
        self.observation_fields = batched.observation_fields

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; no options are known."""
        super().reset(seed=seed)
        self.batched.adopt(self.np_random)
        observations, info = self.batched.reset()
        return observations[0], info

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """One step: no reward, no end."""
        observations, _, _, _, info = self.batched.step(np.asarray(action)[None])
        return observations[0], 0.0, False, False, info

    def render(self) -> Pixels | None:
        """A picture, uint8 [256, w, 3]; None without render mode."""
        frames = self.batched.render()
        return None if frames is None else frames[0]

    def scene(self) -> Scene:
        """What there is to see."""
        return self.batched.scene()

    def experts(self) -> tuple[Expert, ...]:
        """Scripted experts, one for each task the world is used for."""
        return self.batched.experts()

    def finite_model(self) -> FiniteModel | None:
        """The task as a finite deterministic model; None if that would say too little."""
        return self.batched.finite_model()

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """The best episodes of `horizon` steps that are known; none where there is a model."""
        return self.batched.known_best(horizon)
