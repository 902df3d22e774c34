"""Cheetah Flip: HalfCheetah, asked to turn over and over forwards (paper, appendix H.1.2)."""

from __future__ import annotations

from importlib.resources import as_file, files
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.known import Known
from tiloilc.tasks.robots.base import Doubles, Field, Floats, RobotEnv
from tiloilc.tasks.robots.camera import View
from tiloilc.tasks.robots.flip_best import shipped_flips
from tiloilc.tasks.robots.flips import FlipExpert
from tiloilc.tasks.scene import Circle, Rectangle, Scene

SUBSTEPS = 5
"""Of 0.01 s each in one step, as in HalfCheetah-v5."""

NOISE = 0.1
"""Of the start, as in HalfCheetah-v5: positions (m, rad) evenly up to it, velocities normally."""

STANDING = 0.5
"""How far the pitch may be from upright for a stand on front or back legs, rad."""

FIELDS = (
    Field("height", 1, -1.0, 1.0),
    Field("pitch", 2, -1.0, 1.0),
    Field("joint_angle", 6, -1.5, 1.5),
    Field("velocity", 2, -10.0, 10.0),
    Field("pitch_rate", 1, -20.0, 20.0),
    Field("joint_velocity", 6, -40.0, 40.0),
)

_WIDE, _HIGH = float(np.sin(STANDING)), float(np.cos(STANDING))

DIAL = Scene(
    (-1.25, -1.25, 1.25, 1.25),
    (
        Circle("", "#e4e4e0", (0.0, 0.0), 1.0),
        Rectangle("b", "#d9534f", (-_WIDE, _HIGH), (_WIDE, 1.1)),
        Rectangle("d", "#5b8fd6", (-_WIDE, -1.1), (_WIDE, -_HIGH)),
    ),
    position=(1, 2),
)
"""The pitch as a point of the unit circle, (cos, sin): it goes round against the clock. On the
circle, the rectangles are the sectors in which it stands on its front and on its back legs."""


class CheetahFlipEnv(RobotEnv):
    """Gymnasium's HalfCheetah-v5, whose pitch is observed as an angle that may go round.

    Six motors in [-1, 1], 0.05 s a step. The observation, float32 [18]:

    height 1          of the trunk over where it stands at rest, m
    pitch 2           cosine and sine of the trunk's pitch θ; θ grows in a front flip, so that at
                      θ = π/2 it stands on its front legs, at -π/2 on its back legs
    joint_angle 6     rad: thigh, shin, foot of the back leg, then of the front leg
    velocity 2        forwards and upwards, m/s
    pitch_rate 1      rad/s
    joint_velocity 6  rad/s

    Where it is along the floor is not observed. Each number is kept within its bounds in FIELDS,
    which are wider than what its motors bring about.
    """

    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(
            _model(),
            substeps=SUBSTEPS,
            fields=FIELDS,
            actions=6,
            view=View((0.0, 0.0, 0.7), 4.0, 90.0, -10.0),
            render_mode=render_mode,
        )
        self.metadata = {**self.metadata, "render_fps": round(1 / self.step_seconds)}

    def scene(self) -> Scene:
        """The pitch on a dial."""
        return DIAL

    def experts(self) -> tuple[Expert, ...]:
        """One that plans with a model of its own; it makes two flips."""
        return (FlipExpert("flip", self.model, self.substeps),)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """What a patient planner did in 1000 steps, or the beginning of it, from one start."""
        episode = shipped_flips()[: horizon + 1]
        if len(episode) <= horizon:
            return ()
        how = (
            f"{rotations(episode)[-1]:.0f} full turns by a planner that looks far ahead: a lower "
            "bound, reached by real actions; from above no bound is known but that the trunk turns "
            f"by at least {2 * np.pi - 4 * STANDING:.1f} rad for a visit"
        )
        return (Known(episode[None], how),)

    def _start(self) -> None:
        positions, velocities = self.model.nq, self.model.nv
        self.data.qpos[:] += self.np_random.uniform(-NOISE, NOISE, positions)
        self.data.qvel[:] += NOISE * self.np_random.standard_normal(velocities)

    def _act(self, action: Doubles) -> None:
        self.data.ctrl[:] = action

    def _observe(self) -> Doubles:
        position = self.data.qpos
        pitch = (np.cos(position[2]), np.sin(position[2]))
        return np.concatenate((position[1:2], pitch, position[3:], self.data.qvel))

    def _look_at(self) -> tuple[float, float, float]:
        return float(self.data.qpos[0]), 0.0, 0.7


def rotations(observations: Floats | Doubles) -> npt.NDArray[np.float64]:
    """Full turns forwards since the first of `observations` [..., T+1, 18], at each time.

    A step turns it by less than half a turn, so that the pitch can be followed.
    """
    pitch = np.arctan2(observations[..., 2], observations[..., 1]).astype(np.float64)
    turned = np.unwrap(pitch, axis=-1)
    return np.asarray((turned - turned[..., :1]) / (2 * np.pi), np.float64)


def _model() -> Any:
    """Gymnasium's half_cheetah.xml."""
    with as_file(files("gymnasium.envs.mujoco") / "assets" / "half_cheetah.xml") as path:
        return mujoco.MjModel.from_xml_path(str(path))
