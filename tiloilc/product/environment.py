"""Many copies of one Gymnasium environment behind one batched interface."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.foreign import blamed, checked, dimensions_of, flat
from tiloilc.spec.model import Environment

if TYPE_CHECKING:
    import gymnasium as gym
    from gymnasium.vector import VectorEnv

Floats = NDArray[np.float32]

MAX_CELLS = 1_000_000
"""Observations beyond which no table is made: images are whole numbers too."""

LONG_STEP = 2e-4
"""Seconds; shorter steps are over before another thread has the interpreter."""


class Copies:
    """`count` copies of an environment: flat float32 observations [n, d], no automatic reset.

    An environment that registers a `vector_entry_point` without automatic reset is stepped as one
    array program, any other one by one; those of MuJoCo by a thread for each core if their steps
    are long, since its physics leaves the interpreter to others. An environment's own time limit is
    not applied: how long an episode is, the task says.
    """

    def __init__(self, environment: Environment, count: int) -> None:
        self.count, self.id = count, environment.id
        name = _import_module_of(environment.id)
        self.vector = _batched(name, environment, count)
        self.singles: list[gym.Env[Any, Any]] = []
        if self.vector is None:
            with blamed(self.id, "it cannot be made", __file__):
                self.singles = [_single(name, environment) for _ in range(count)]
            self.observation_space = self.singles[0].observation_space
            self.action_space = self.singles[0].action_space
        else:
            self.observation_space = self.vector.single_observation_space
            self.action_space = self.vector.single_action_space
        self.finite = is_finite(self.observation_space, self.action_space)
        self.dimensions = dimensions_of(self.observation_space)
        self._seen: Floats = np.zeros((count, self.dimensions), dtype=np.float32)
        self._range = bounds(self.observation_space) if self.finite else None
        self._threads: ThreadPoolExecutor | None = None
        self._shares = [range(count)]
        self._untimed = bool(self.singles) and _by_mujoco(self.singles[0])

    def reset(self, seeds: Sequence[int], mask: NDArray[np.bool_]) -> Floats:
        """Begin an episode in the copies of `mask`; `seeds` has one entry for each copy.

        Returns the observations of all copies, [n, d]. Raises CompileError RUN707 if the
        environment fails.
        """
        if self.vector is not None:
            observations, _ = self.vector.reset(
                seed=list(seeds),  # type: ignore[arg-type]  # all vector environments take a list
                options={"reset_mask": mask},
            )
            return self._flat(observations)

        def begin(i: int) -> None:
            if mask[i]:
                observation, _ = self.singles[i].reset(seed=int(seeds[i]))
                self._seen[i] = self._checked(observation)

        self._each(begin, "reset() fails")
        return self._seen.copy()

    def step(self, actions: NDArray[Any]) -> tuple[Floats, NDArray[np.bool_]]:
        """Step all copies: observations [n, d] and who has terminated [n].

        A copy that has terminated must be reset before the next step. Raises CompileError RUN707
        if the environment fails, or returns what is no observation of its space.
        """
        if self.vector is not None:
            observations, _, terminated, _, _ = self.vector.step(actions)
            return self._flat(observations), np.asarray(terminated, dtype=np.bool_)
        ended = np.zeros(self.count, dtype=np.bool_)

        def go_on(i: int) -> None:
            observation, _, ended[i], _, _ = self.singles[i].step(actions[i])
            self._seen[i] = self._checked(observation)

        began = time.perf_counter()
        self._each(go_on, "step() fails")
        if self._untimed:
            self._share_out((time.perf_counter() - began) / self.count)
        return self._seen.copy(), ended

    def close(self) -> None:
        """Give the environments back."""
        if self.vector is not None:
            self.vector.close()
        for single in self.singles:
            single.close()
        if self._threads is not None:
            self._threads.shutdown()

    def _share_out(self, seconds: float) -> None:
        """Have threads step the copies from now on, if a step of one takes so long that it pays."""
        self._untimed = False
        threads = min(self.count, _cores())
        if threads > 1 and seconds > LONG_STEP:
            self._threads = ThreadPoolExecutor(threads)
            self._shares = [range(i, self.count, threads) for i in range(threads)]

    def _each(self, do: Callable[[int], None], fails: str) -> None:
        """`do` it for every copy; whatever goes wrong is the environment's."""

        def do_share(share: range) -> None:
            for i in share:
                do(i)

        run = map if self._threads is None else self._threads.map
        with blamed(self.id, fails, __file__):
            list(run(do_share, self._shares))

    def _checked(self, observation: Any) -> Floats:
        """One observation, flat. Raises ValueError if it cannot be learned from."""
        row = checked(self.observation_space, observation, self.dimensions)
        if self._range is not None and ((row < self._range[0]) | (row > self._range[1])).any():
            raise ValueError("an observation outside the observation space")
        return row

    def _flat(self, observations: Any) -> Floats:
        if isinstance(observations, dict):
            singles = [{k: v[i] for k, v in observations.items()} for i in range(self.count)]
            return np.stack([flat(self.observation_space, single) for single in singles])
        return np.array(observations, dtype=np.float32).reshape(self.count, -1)


def single(environment: Environment) -> gym.Env[Any, Any]:
    """One copy of an environment as it is: no time limit of its own, its observations not flat."""
    return _single(_import_module_of(environment.id), environment)


def is_finite(observation_space: gym.Space[Any], action_space: gym.Space[Any]) -> bool:
    """Whether both spaces are finite and small, so that values fit a table."""
    from gymnasium import spaces

    whole = isinstance(
        observation_space, spaces.Discrete | spaces.MultiDiscrete | spaces.MultiBinary
    ) or (
        isinstance(observation_space, spaces.Box)
        and np.issubdtype(observation_space.dtype, np.integer)
    )
    if not whole or not isinstance(action_space, spaces.Discrete):
        return False
    low, high = bounds(observation_space)
    cells = 1
    for first, last in zip(low.tolist(), high.tolist(), strict=True):
        cells *= int(last) - int(first) + 1
        if cells > MAX_CELLS:
            return False
    return True


def bounds(space: gym.Space[Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The least and the greatest flat observation of a finite space."""
    from gymnasium import spaces

    low: Any = 0
    high: Any = 1
    match space:
        case spaces.Discrete():
            low, high = space.start, space.start + space.n - 1
        case spaces.MultiDiscrete():
            low, high = space.start, space.start + space.nvec - 1
        case spaces.Box():
            low, high = space.low, space.high
        case spaces.MultiBinary():
            low, high = np.zeros(space.shape), np.ones(space.shape)
    return np.asarray(low, np.float64).reshape(-1), np.asarray(high, np.float64).reshape(-1)


def _batched(name: str, environment: Environment, count: int) -> VectorEnv[Any, Any, Any] | None:
    """The environment's own batched form, None if it has none that leaves resets to us.

    Raises CompileError JOB607 if that is the only form it has.
    """
    import gymnasium as gym
    from gymnasium.vector import AutoresetMode

    spec = gym.spec(name)
    if spec.vector_entry_point is None:
        return None
    vector: VectorEnv[Any, Any, Any] = gym.make_vec(
        name,
        num_envs=count,
        vectorization_mode="vector_entry_point",
        **environment.kwargs,
    )
    if vector.metadata.get("autoreset_mode") == AutoresetMode.DISABLED:
        return vector
    vector.close()
    if spec.entry_point is None:
        raise CompileError(Diagnostic.of("JOB607", id=environment.id))
    return None


def _single(name: str, environment: Environment) -> gym.Env[Any, Any]:
    """One copy, without a time limit of its own and without the checks of every step."""
    import gymnasium as gym

    unlimited = {"max_episode_steps": -1, "disable_env_checker": True}
    return gym.make(name, **{**unlimited, **environment.kwargs})


def _by_mujoco(single: gym.Env[Any, Any]) -> bool:
    """Whether MuJoCo does the work of an environment's steps."""
    model = getattr(single.unwrapped, "model", None)
    return type(model).__module__.partition(".")[0] == "mujoco"


def _cores() -> int:
    """The processors that this process may use, and no more than `OMP_NUM_THREADS` says."""
    able = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    return min(able or 1, int(wanted) if wanted.isdecimal() and int(wanted) else able or 1)


def _import_module_of(name: str) -> str:
    """Import what registers `name`: the part before a colon, or the project's own tasks."""
    module, _, rest = name.rpartition(":")
    if module:
        importlib.import_module(module)
    elif name.startswith("tiloilc/"):
        importlib.import_module("tiloilc.tasks")
    return rest
