"""The Fetch arm over its table, as in Gymnasium-Robotics' Fetch environments of version 4.

The robot, its meshes and its motors are that package's own files, with a task's things added to
them. What moves it is written here, to the letter of that package, whose own steps take twice as
long and whose classes are tied to versions of MuJoCo.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from gymnasium.error import DependencyNotInstalled

from tiloilc.tasks.robots.base import Doubles, Field, RobotEnv
from tiloilc.tasks.robots.camera import View

SUBSTEPS = 20
"""Of 2 ms each: 25 actions a second."""

REACH = 0.05
"""Metres that a full action asks the gripper to move along an axis. It makes 33 mm of them, and up
to 47 mm where it turns round: this is what a step cannot exceed."""

STARTS = 2
"""Episodes that are played to know what is possible where they are long."""

JOINTS = {"robot0:slide0": 0.405, "robot0:slide1": 0.48, "robot0:slide2": 0.0}
"""Where the robot stands beside its table."""

HOVER = np.array((-0.498, 0.005, -0.231))
"""From where the gripper is then to where it begins, over the table."""

TABLE = (1.05, 0.40, 1.55, 1.10)
"""x_min, y_min, x_max, y_max of the table, in metres; its top is at z = 0.4."""

TOP = 0.4
HALF = 0.025
"""Half the edge of a block."""

START = (1.342, 0.749)
"""Where the gripper begins, over the table."""

UNSEEN = (0.0, 0.0, 0.0, 0.0)
"""A colour."""

SEEN = View(look_at=(1.3, 0.75, 0.5), distance=1.6, azimuth=145.0, elevation=-30.0)

GRIP = Field("grip", 3, (1.05, 0.4, 0.4), (1.75, 1.1, 0.9))
FINGERS = Field("fingers", 2, 0.0, 0.05)
GRIP_VELOCITY = Field("grip_velocity", 3, -0.05, 0.05)


@dataclass(frozen=True, eq=False)
class Arm:
    """A compiled scene, and the positions and velocities in which its episodes begin."""

    model: Any
    qpos: Doubles
    qvel: Doubles


def build(
    file: str, furnish: Callable[[Any], None], shift: tuple[float, float, float] = (0, 0, 0)
) -> Arm:
    """The arm of one of Gymnasium-Robotics' scenes with things added to it.

    `furnish` adds them to the `mujoco.MjSpec`; `shift` is from where the gripper begins there to
    where it begins here, in metres. Raises DependencyNotInstalled without that package.
    """
    found = find_spec("gymnasium_robotics")
    if found is None or found.origin is None:
        raise DependencyNotInstalled("gymnasium-robotics is not installed")
    scene = Path(found.origin).parent / "envs" / "assets" / "fetch" / file
    spec = mujoco.MjSpec.from_file(str(scene))
    spec.site("target0").rgba = UNSEEN  # their goal, not ours
    for mark in spec.body("robot0:mocap").geoms:
        mark.rgba = UNSEEN
    furnish(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    for name, value in JOINTS.items():
        data.joint(name).qpos[:] = value
    welds = model.eq_type == int(mujoco.mjtEq.mjEQ_WELD)
    model.eq_data[welds, :7] = (0, 0, 0, 0, 0, 0, 1)
    mujoco.mj_forward(model, data)
    hand = model.body("robot0:mocap").mocapid[0]
    data.mocap_pos[hand] = data.site("robot0:grip").xpos + HOVER + shift
    data.mocap_quat[hand] = (1, 0, 1, 0)
    mujoco.mj_step(model, data, nstep=10 * SUBSTEPS)
    return Arm(model, data.qpos.copy(), data.qvel.copy())


def rgba(color: str, opacity: float = 1.0) -> tuple[float, float, float, float]:
    """A colour `#rrggbb` as MuJoCo takes it."""
    red, green, blue = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue, opacity


def paint(
    spec: Any,
    name: str,
    color: str,
    middle: tuple[float, float, float],
    half: tuple[float, float, float],
    *,
    opacity: float = 0.5,
) -> None:
    """Add a coloured box that nothing can touch."""
    spec.worldbody.add_site(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=middle,
        size=half,
        rgba=rgba(color, opacity),
    )


class FetchEnv(RobotEnv):
    """An arm whose gripper moves by up to 5 cm along x, y and z, and opens or closes.

    blocked  the gripper stays closed, whatever the fourth component of an action is
    """

    def __init__(
        self, arm: Arm, fields: Sequence[Field], *, blocked: bool, render_mode: str | None
    ) -> None:
        super().__init__(
            arm.model,
            substeps=SUBSTEPS,
            fields=fields,
            actions=4,
            view=SEEN,
            render_mode=render_mode,
        )
        self.blocked = blocked
        self._arm = arm
        model = arm.model
        self._hand = int(model.body("robot0:gripper_link").id)
        self._mocap = int(model.body("robot0:mocap").mocapid[0])
        self._grip = int(model.site("robot0:grip").id)
        fingers = [model.joint(f"robot0:{side}_gripper_finger_joint") for side in "rl"]
        self._finger_qpos = np.array([int(joint.qposadr[0]) for joint in fingers])
        self._finger_qvel = np.array([int(joint.dofadr[0]) for joint in fingers])
        self._driven = np.array(
            [int(model.jnt_qposadr[joint]) for joint in model.actuator_trnid[:, 0]], np.int64
        )
        self._jacobian = np.zeros((3, model.nv))

    def _start(self) -> None:
        self.data.qpos[:] = self._arm.qpos
        self.data.qvel[:] = self._arm.qvel
        self._furnish()

    def _furnish(self) -> None:
        """Draw where the task's things are, and put them there."""

    def _act(self, action: Doubles) -> None:
        grasp = 0.0 if self.blocked else action[3]
        self.data.ctrl[:] = self.data.qpos[self._driven] + grasp
        self.data.mocap_pos[self._mocap] = self.data.xpos[self._hand] + REACH * action[:3]
        self.data.mocap_quat[self._mocap] = self.data.xquat[self._hand] + (1, 0, 1, 0)

    def _settle(self) -> None:
        if self.blocked:
            self.data.qpos[self._finger_qpos] = 0
            mujoco.mj_forward(self.model, self.data)

    def put(self, joint: str, x: float, y: float, z: float) -> None:
        """Put a free body there, at rest and level."""
        free = self.data.joint(joint)
        free.qpos[:] = (x, y, z, 1, 0, 0, 0)
        free.qvel[:] = 0

    def grip(self) -> Doubles:
        """Between the fingers' tips: x, y, z in metres."""
        place: Doubles = self.data.site_xpos[self._grip]
        return place.copy()

    def fingers(self) -> tuple[Doubles, Doubles]:
        """How far each finger is from the middle, in metres, and its velocity, in metres a step."""
        moved = self.data.qvel[self._finger_qvel] * self.step_seconds
        return self.data.qpos[self._finger_qpos], moved

    def motion(self, site: int) -> tuple[Doubles, Doubles]:
        """How a site moves (metres a step) and turns (radians a step)."""
        turn = np.zeros_like(self._jacobian)
        mujoco.mj_jacSite(self.model, self.data, self._jacobian, turn, site)
        velocity = self.data.qvel * self.step_seconds
        return self._jacobian @ velocity, turn @ velocity


def euler(matrix: Doubles) -> Doubles:
    """The angles, in radians, about x, y and z of a rotation matrix [9], as Gymnasium-Robotics
    gives them."""
    m = matrix.reshape(3, 3)
    across = float(np.hypot(m[2, 2], m[1, 2]))
    about_y = -np.arctan2(-m[0, 2], across)
    if across > 1e-15:
        return np.array([-np.arctan2(m[1, 2], m[2, 2]), about_y, -np.arctan2(m[0, 1], m[0, 0])])
    return np.array([0.0, about_y, -np.arctan2(-m[1, 0], m[1, 1])])
