"""What all MuJoCo tasks share: seeding, stepping, observations of named fields, pictures."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import mujoco
import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.robots.camera import Camera, View
from tiloilc.tasks.scene import Pixels, Scene, rasterise

Floats = npt.NDArray[np.float32]
Doubles = npt.NDArray[np.float64]

HEIGHT = 480
"""Of a picture, in pixels; it is as wide."""


@dataclass(frozen=True, slots=True)
class Field:
    """A named part of the observation: `size` numbers, kept between `low` and `high`.

    The bounds are one number, or one a component. Learners scale by them, so they are those of
    what a task makes of its robot, not of what could be.
    """

    name: str
    size: int
    low: float | tuple[float, ...]
    high: float | tuple[float, ...]


class RobotEnv(gymnasium.Env[Floats, Floats]):
    """A task on a MuJoCo model: no reward, no end. A task says how it starts, acts and looks.

    `reset(seed)` determines the state whole, MuJoCo's warm start included: the same seed and
    actions give the same observations, bit for bit. The model may be shared by many environments
    and is never written to: what an episode draws goes into `data`.

    model     a compiled `mujoco.MjModel`
    substeps  steps of physics in one step
    fields    the observation, part after part
    actions   numbers in an action, each in [-1, 1]
    view      where pictures are taken from
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  # as Gymnasium declares it
        "render_modes": ["rgb_array"],
        "render_fps": 25,
    }

    def __init__(
        self,
        model: Any,
        *,
        substeps: int,
        fields: Sequence[Field],
        actions: int,
        view: View,
        render_mode: str | None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode must be 'rgb_array' or None, not {render_mode!r}")
        self.render_mode = render_mode
        self.model = model
        self.data = mujoco.MjData(model)
        self.substeps = substeps
        self.observation_fields = _slices(fields)
        low = np.concatenate([np.broadcast_to(f.low, f.size) for f in fields])
        high = np.concatenate([np.broadcast_to(f.high, f.size) for f in fields])
        self.observation_space = Box(low.astype(np.float32), high.astype(np.float32))
        self.action_space = Box(-1.0, 1.0, (actions,), np.float32)
        self._low, self._high = self.observation_space.low, self.observation_space.high
        self._view = view
        self._camera: Camera | None = None
        self._blind = False
        self._begun = False

    @property
    def step_seconds(self) -> float:
        """Seconds that pass in one step."""
        return float(self.model.opt.timestep) * self.substeps

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode; no options are known."""
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        self._start()
        mujoco.mj_forward(self.model, self.data)
        self._begun = True
        return self._seen(), {}

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """One step: no reward, no end. Raises ValueError for what is no action."""
        if not self._begun:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        push = np.asarray(action, np.float64)
        if push.shape != self.action_space.shape:
            raise ValueError(
                f"an action must have shape {self.action_space.shape}, not {push.shape}"
            )
        if not np.isfinite(push).all():
            raise ValueError("an action must be finite")
        self._act(np.clip(push, -1.0, 1.0))
        mujoco.mj_step(self.model, self.data, nstep=self.substeps)
        self._settle()
        return self._seen(), 0.0, False, False, {}

    def render(self) -> Pixels | None:
        """A picture, uint8 [480, 480, 3]; None without render mode.

        Where MuJoCo cannot draw, it is the scene from above, uint8 [256, w, 3].
        """
        if self.render_mode is None:
            return None
        if not self._begun:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        if not self._blind:
            try:
                if self._camera is None:
                    self._camera = Camera(self.model, self._view, HEIGHT, HEIGHT)
                return self._camera.picture(self.data, self._look_at())
            except Exception:  # a picture is never worth a run
                self._blind, self._camera = True, None
        scene = self.scene()
        return rasterise(scene, self._seen()[list(scene.position)])

    def close(self) -> None:
        """Give the graphics memory back."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def _seen(self) -> Floats:
        return np.clip(self._observe().astype(np.float32), self._low, self._high)

    @abstractmethod
    def scene(self) -> Scene:
        """What there is to see from above."""

    @abstractmethod
    def experts(self) -> tuple[Expert, ...]:
        """Scripted experts, one for each task the world is used for."""

    @abstractmethod
    def _start(self) -> None:
        """Put `data`, which is as MuJoCo resets it, into an initial state drawn from `np_random`.

        Positions that follow from others are computed afterwards.
        """

    @abstractmethod
    def _act(self, action: Doubles) -> None:
        """Write an action, components in [-1, 1], into `data`."""

    @abstractmethod
    def _observe(self) -> Doubles:
        """What is seen of `data`, field after field."""

    def _settle(self) -> None:
        """What is put right after a step."""

    def _look_at(self) -> tuple[float, float, float] | None:
        """The point that the camera follows; None: it stands still."""
        return None


def _slices(fields: Sequence[Field]) -> dict[str, slice | int]:
    """Where each field stands; one number by its index."""
    places: dict[str, slice | int] = {}
    at = 0
    for field in fields:
        places[field.name] = at if field.size == 1 else slice(at, at + field.size)
        at += field.size
    return places
