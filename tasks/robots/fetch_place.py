"""FetchPlace Tray and FetchPlace Button: a block is taken and carried (paper, appendix H)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import mujoco
import numpy as np

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.robots.base import Doubles, Field
from tiloilc.tasks.robots.fetch import (
    FINGERS,
    GRIP_VELOCITY,
    HALF,
    TABLE,
    TOP,
    UNSEEN,
    Arm,
    FetchEnv,
    build,
    euler,
    rgba,
)
from tiloilc.tasks.robots.fetch_experts import Placer, Presser
from tiloilc.tasks.scene import Circle, Rectangle, Scene

WIDE = (1.05, 0.4, 0.4), (1.55, 1.1, 0.8)
"""Where the gripper and the block are, in metres: over the table."""

BLOCK_FIELDS = (
    Field("grip", 3, *WIDE),
    Field("block", 3, *WIDE),
    Field("away", 3, -0.35, 0.35),
    FINGERS,
    Field("turn", 3, -np.pi, np.pi),
    Field("block_velocity", 3, -0.05, 0.05),
    Field("block_spin", 3, -0.5, 0.5),
    GRIP_VELOCITY,
    Field("finger_velocity", 2, -0.02, 0.02),
)
"""The 25 numbers of Gymnasium-Robotics' FetchPickAndPlace, in its order and units."""

BLOCK_FROM, BLOCK_TO = (1.25, 0.69), (1.43, 0.79)
"""The rectangle that the block's first place is drawn from."""

TRAY_FROM, TRAY_TO = (1.22, 0.92), (1.42, 1.0)
TRAY_HALF = 0.08
"""Half the edge of a tray."""

RIM = 0.01
"""How thick a tray's floor and rim are; the rim stands as much over the floor."""

INSIDE = 0.05
"""How far from the tray's middle, along x and y, a block may be that lies in it."""

GOAL = (1.32, 0.56)
"""The middle of the goal region of FetchPlace Tray, on the table."""

NEAR = 0.05
"""Metres from a block to the goal, or from the gripper to the button, that count as there."""

GOAL_FROM, GOAL_TO = (1.22, 0.58, 0.45), (1.44, 0.80, 0.62)
"""The box that the goals of FetchPlace Button are drawn from: over the table."""

BUTTON_FROM, BUTTON_TO = (1.22, 0.93), (1.42, 1.0)
BUTTON_Z = 0.46
"""How high the gripper presses the button: a block in it stays clear of the table."""

BURIED = -0.5
"""z of what is not there."""


class _BlockEnv(FetchEnv):
    """An arm and a block, and after what is seen of them a task's own fields."""

    def __init__(self, arm: Arm, fields: Sequence[Field], render_mode: str | None) -> None:
        super().__init__(arm, (*BLOCK_FIELDS, *fields), blocked=False, render_mode=render_mode)
        self._block = int(self.model.site("object0").id)
        self._pads = [int(self.model.geom(f"robot0:{s}_gripper_finger_link").id) for s in "rl"]

    def block(self) -> Doubles:
        """The block's middle: x, y, z in metres."""
        place: Doubles = self.data.site_xpos[self._block]
        return place.copy()

    def place(self, thing: str, position: Sequence[float] | Doubles) -> None:
        """Put one of the things that only we move there."""
        self.data.mocap_pos[self.model.body(thing).mocapid[0]] = position

    def touched(self) -> bool:
        """Whether both fingers touch the block."""
        block = int(self.model.geom("object0").id)
        pairs = self.data.contact.geom
        return all(
            bool((np.sort(pairs, axis=1) == sorted((block, finger))).all(axis=1).any())
            for finger in self._pads
        )

    def _furnish(self) -> None:
        x, y = self.np_random.uniform(BLOCK_FROM, BLOCK_TO)
        self.put("object0:joint", x, y, TOP + HALF)

    def _observe(self) -> Doubles:
        grip, (fingers, opening), moved = self.grip(), self.fingers(), self.motion(self._grip)[0]
        place, (velocity, spin) = self.block(), self.motion(self._block)
        turn = euler(self.data.site_xmat[self._block])
        away = place - grip
        return np.concatenate(
            [grip, place, away, fingers, turn, velocity - moved, spin, moved, opening]
        )

    def _block_shape(self) -> Rectangle:
        x, y, _ = self.block().tolist()
        return Rectangle("block", "#5b5b66", (x - HALF, y - HALF), (x + HALF, y + HALF))


class FetchPlaceTrayEnv(_BlockEnv):
    """A block to be put into the tray, or into the goal region where there is no tray.

    The observation, 28 float32 numbers:

    grip, block      3 + 3  m, where the gripper and the block's middle are
    away             3      m, from the gripper to the block
    fingers          2      m, from the middle
    turn             3      rad, of the block about x, y and z
    block_velocity   3      m a step, seen from the gripper
    block_spin       3      rad a step
    grip_velocity    3      m a step
    finger_velocity  2      m a step
    tray             2      m, x and y of its middle; (1.05, 0.4), the table's corner, without
    present          1      1 with a tray, 0 without

    tray  whether there is a tray; None: in every second episode, by chance
    """

    def __init__(self, tray: bool | None = None, render_mode: str | None = None) -> None:
        low, high = TABLE[:2], TABLE[2:]
        fields = (Field("tray", 2, low, high), Field("present", 1, 0.0, 1.0))
        super().__init__(_with_tray(), fields, render_mode)
        self.tray = tray
        self._tray: tuple[float, float] | None = None

    def scene(self) -> Scene:
        """The table, the goal region, the tray if there is one, and the block."""
        shapes: list[Circle | Rectangle] = [_table(), Circle("InGoal", "#d9534f", GOAL, NEAR)]
        if self._tray is not None:
            x, y = self._tray
            shapes += [
                Rectangle(name, color, (x - half, y - half), (x + half, y + half))
                for name, color, half in (
                    ("tray", "#8a6d4b", TRAY_HALF),
                    ("InTray", "#c9a878", INSIDE),
                )
            ]
        return Scene(TABLE, (*shapes, self._block_shape()))

    def experts(self) -> tuple[Expert, ...]:
        """One: takes the block and puts it where it belongs."""
        return (Placer("tray", goal=GOAL),)

    def _furnish(self) -> None:
        super()._furnish()
        x, y = self.np_random.uniform(TRAY_FROM, TRAY_TO).tolist()
        drawn = bool(self.np_random.random() < 0.5)
        self._tray = (x, y) if (drawn if self.tray is None else self.tray) else None
        self.place("tray", (x, y, TOP if self._tray else BURIED))

    def _observe(self) -> Doubles:
        there = self._tray is not None
        return np.concatenate([super()._observe(), self._tray or TABLE[:2], [float(there)]])


class FetchPlaceButtonEnv(_BlockEnv):
    """A block to be carried to the goal, then a button to be pressed, which draws a new goal.

    The observation, 31 float32 numbers: the first 25 are those of FetchPlaceTrayEnv, then

    goal    3  m, where the block shall be
    button  3  m, where the gripper shall be to press it

    The goal changes in the step in which the gripper comes within 5 cm of the button.
    """

    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(
            _with_button(), (Field("goal", 3, *WIDE), Field("button", 3, *WIDE)), render_mode
        )
        self._goal = np.zeros(3)
        self._button = np.zeros(3)
        self._pressed = False

    def scene(self) -> Scene:
        """The table, the goal, the button and the block."""
        goal, button = self._goal.tolist(), self._button.tolist()
        shapes = (
            Circle("GoalReached", "#d9534f", (goal[0], goal[1]), NEAR),
            Circle("ButtonReached", "#4caf6d", (button[0], button[1]), NEAR),
        )
        return Scene(TABLE, (_table(), *shapes, self._block_shape()))

    def experts(self) -> tuple[Expert, ...]:
        """One: keeps the block in hand, two rounds of goal and button."""
        return (Presser("button", laps=2),)

    def _furnish(self) -> None:
        super()._furnish()
        self._button = np.array([*self.np_random.uniform(BUTTON_FROM, BUTTON_TO), BUTTON_Z])
        self._pressed = False
        self.place("button", self._button)
        self._draw_goal()

    def _settle(self) -> None:
        reached = float(np.linalg.norm(self.grip() - self._button)) < NEAR
        if reached and not self._pressed:
            self._draw_goal()
        self._pressed = reached

    def _draw_goal(self) -> None:
        self._goal = self.np_random.uniform(GOAL_FROM, GOAL_TO)
        self.place("goal", self._goal)

    def _observe(self) -> Doubles:
        return np.concatenate([super()._observe(), self._goal, self._button])


def _table() -> Rectangle:
    return Rectangle("table", "#e9e7e1", TABLE[:2], TABLE[2:])


def _plain_block(spec: Any) -> None:
    spec.geom("object0").material, spec.geom("object0").rgba = "", rgba("#5b5b66")
    spec.site("object0").rgba = UNSEEN


@cache
def _with_tray() -> Arm:
    def furnish(spec: Any) -> None:
        _plain_block(spec)
        spec.worldbody.add_site(
            name="goal",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            pos=(*GOAL, TOP),
            size=(NEAR, 0.001, 0),
            rgba=rgba("#d9534f", 0.7),
        )
        tray = spec.worldbody.add_body(name="tray", mocap=True, pos=(0, 0, BURIED))
        rim = TRAY_HALF - RIM / 2
        for x, y, z, half in (
            (0, 0, RIM / 2, (TRAY_HALF, TRAY_HALF, RIM / 2)),
            (rim, 0, RIM, (RIM / 2, TRAY_HALF, RIM)),
            (-rim, 0, RIM, (RIM / 2, TRAY_HALF, RIM)),
            (0, rim, RIM, (TRAY_HALF, RIM / 2, RIM)),
            (0, -rim, RIM, (TRAY_HALF, RIM / 2, RIM)),
        ):
            tray.add_geom(
                type=mujoco.mjtGeom.mjGEOM_BOX, pos=(x, y, z), size=half, rgba=rgba("#8a6d4b")
            )

    return build("pick_and_place.xml", furnish)


@cache
def _with_button() -> Arm:
    def furnish(spec: Any) -> None:
        _plain_block(spec)
        goal = spec.worldbody.add_body(name="goal", mocap=True)
        goal.add_site(
            name="goal",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=(NEAR, 0, 0),
            rgba=rgba("#d9534f", 0.4),
        )
        button = spec.worldbody.add_body(name="button", mocap=True)
        button.add_site(
            name="button",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            pos=(0, 0, (TOP - BUTTON_Z) / 2),
            size=(0.03, (BUTTON_Z - TOP) / 2, 0),
            rgba=rgba("#4caf6d", 0.6),
        )

    return build("pick_and_place.xml", furnish)
