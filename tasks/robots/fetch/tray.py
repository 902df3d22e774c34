"""FetchPlace Tray: a block is put into the tray, or into the goal region if there is no tray."""

from __future__ import annotations

from functools import cache
from typing import Any

import mujoco
import numpy as np

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.known import Known, played
from tiloilc.tasks.robots.base import Doubles, Field
from tiloilc.tasks.robots.fetch.arm import STARTS, TABLE, TOP, Arm, build, rgba
from tiloilc.tasks.robots.fetch.block import (
    GOAL_COLOR,
    NEAR,
    BlockEnv,
    grown,
    plain_block,
)
from tiloilc.tasks.robots.fetch.experts import Placer
from tiloilc.tasks.scene import Circle, Rectangle, Scene

TRAY_FROM, TRAY_TO = (1.22, 0.92), (1.42, 1.0)
TRAY_HALF = 0.08
"""Half the edge of a tray."""

RIM = 0.01
"""How thick a tray's floor and rim are; the rim stands as much over the floor."""

INSIDE = 0.05
"""How far from the tray's middle, along x and y, a block may be that lies in it."""

GOAL = (1.32, 0.56)
"""The middle of the goal region of FetchPlace Tray, on the table."""

BURIED = -0.5
"""z of what is not there."""


class FetchPlaceTrayEnv(BlockEnv):
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
        """The table, the goal region, the block, and the tray if there is one.

        Before a reset: where block and tray may be.
        """
        table, block = self.ground()
        shapes: list[Circle | Rectangle] = [table, Circle("InGoal", GOAL_COLOR, GOAL, NEAR)]
        low, high = (TRAY_FROM, TRAY_TO) if not self._begun else (self._tray, self._tray)
        if low is not None and high is not None:
            shapes.append(Rectangle("tray", "#8a6d4b", *grown(low, high, TRAY_HALF)))
            shapes.append(Rectangle("InTray", "#c9a878", *grown(low, high, INSIDE)))
        return Scene(TABLE, (*shapes, block))

    def experts(self) -> tuple[Expert, ...]:
        """One: takes the block and puts it where it belongs."""
        return (Placer("tray", goal=GOAL),)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """The expert without noise, from a few starts."""
        how = (
            "a scripted controller that takes the block straight there: a lower bound, reached by "
            f"real actions from {STARTS} starts"
        )
        expert = Placer("tray", noise=0.0, dwell=horizon, goal=GOAL)
        return (played(FetchPlaceTrayEnv(self.tray), expert, horizon, STARTS, how),)

    def _furnish(self) -> None:
        super()._furnish()
        x, y = self.np_random.uniform(TRAY_FROM, TRAY_TO).tolist()
        drawn = bool(self.np_random.random() < 0.5)
        self._tray = (x, y) if (drawn if self.tray is None else self.tray) else None
        self.place("tray", (x, y, TOP if self._tray else BURIED))

    def _observe(self) -> Doubles:
        there = self._tray is not None
        return np.concatenate([super()._observe(), self._tray or TABLE[:2], [float(there)]])


@cache
def _with_tray() -> Arm:
    def furnish(spec: Any) -> None:
        plain_block(spec)
        spec.worldbody.add_site(
            name="goal",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            pos=(*GOAL, TOP),
            size=(NEAR, 0.001, 0),
            rgba=rgba(GOAL_COLOR, 0.7),
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
