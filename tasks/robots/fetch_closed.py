"""Fetch Avoid and Fetch Align: the gripper stays closed (paper, appendix H)."""

from __future__ import annotations

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
    START,
    TABLE,
    TOP,
    UNSEEN,
    Arm,
    FetchEnv,
    build,
    euler,
    paint,
    rgba,
)
from tiloilc.tasks.robots.fetch_experts import Aligner, Reacher
from tiloilc.tasks.scene import Rectangle, Scene

FAR = 1.70
"""x from which on the arm counts as stretched out, in metres; it reaches 1.78."""

CORRIDOR = 0.04
"""How far the gripper may leave its first y to either side."""

LINE = 1.30
"""x of the line across the middle of the table."""

ALIGNED = 0.03
"""A cube is on the line if its middle is nearer than this, in metres."""

SPREAD = 0.12
"""Metres between neighbouring cubes, along the line."""

NEAR, AWAY = 0.05, 0.08
"""How far from the line a cube begins at least and at most: all on the robot's side."""

BEHIND = (-0.19, -SPREAD, -0.1)
"""From where the gripper usually begins to where it does here: low, behind the first cube."""

CUBES = ("cube1", "cube2", "cube3")
COLORS = ("#d9534f", "#4caf6d", "#5b8fd6")


class FetchAvoidEnv(FetchEnv):
    """An arm that is to stretch out without swerving. The observation, 10 float32 numbers:

    grip             3  m, where the gripper is; it begins at x = 1.342, y = 0.749
    fingers          2  m, from the middle
    grip_velocity    3  m a step
    finger_velocity  2  m a step
    """

    def __init__(self, render_mode: str | None = None) -> None:
        y = START[1]
        fields = (
            Field("grip", 3, (1.1, y - 0.1, 0.4), (1.8, y + 0.1, 0.7)),
            FINGERS,
            GRIP_VELOCITY,
            Field("finger_velocity", 2, -0.01, 0.01),
        )
        super().__init__(_corridor(), fields, blocked=True, render_mode=render_mode)

    def scene(self) -> Scene:
        """The table and the corridor over it; `z` is what lies beside the corridor."""
        x_min, y_min, x_max, y_max = TABLE
        left, right = START[1] + CORRIDOR, START[1] - CORRIDOR
        return Scene(
            (x_min, y_min, 1.85, y_max),
            (
                Rectangle("table", "#e9e7e1", (x_min, y_min), (x_max, y_max)),
                Rectangle("z", "#efc7c5", (x_min, y_min), (1.85, right)),
                Rectangle("z", "#efc7c5", (x_min, left), (1.85, y_max)),
                Rectangle("a", "#4caf6d", (FAR, right), (1.85, left)),
            ),
        )

    def experts(self) -> tuple[Expert, ...]:
        """One: straight on."""
        return (Reacher("avoid", dwell=10, aim=(FAR + 0.04, START[1], 0.535), arrived=FAR),)

    def _observe(self) -> Doubles:
        fingers, opening = self.fingers()
        return np.concatenate([self.grip(), fingers, self.motion(self._grip)[0], opening])


class FetchAlignEnv(FetchEnv):
    """Three cubes to be pushed onto a line. The observation, 45 float32 numbers:

    grip             3  m, where the gripper is
    grip_velocity    3  m a step
    fingers          2  m, from the middle
    finger_velocity  1  m a step, the mean of both
    and for i = 1, 2, 3
    cubei            3  m, its middle
    cubei_away       3  m, from the gripper to it
    cubei_turn       3  rad, about x, y and z
    cubei_velocity   3  m a step, seen from the gripper
    """

    def __init__(self, render_mode: str | None = None) -> None:
        fields = [
            Field("grip", 3, (1.0, 0.45, 0.4), (1.5, 1.05, 0.6)),
            GRIP_VELOCITY,
            FINGERS,
            Field("finger_velocity", 1, -0.01, 0.01),
        ]
        for i, name in enumerate(CUBES):
            y = _row(i)
            fields += [
                Field(name, 3, (1.15, y - 0.1, 0.4), (1.45, y + 0.1, 0.5)),
                Field(f"{name}_away", 3, (-0.3, -0.4, -0.1), (0.3, 0.4, 0.1)),
                Field(f"{name}_turn", 3, -np.pi, np.pi),
                Field(f"{name}_velocity", 3, -0.05, 0.05),
            ]
        super().__init__(_cubes(), fields, blocked=True, render_mode=render_mode)
        self._cubes = [int(self.model.site(f"object{i}").id) for i in range(len(CUBES))]

    def scene(self) -> Scene:
        """The table, the line in its middle, and the cubes where they are."""
        x_min, y_min, x_max, y_max = TABLE
        band = Rectangle("line", "#f0e2b6", (LINE - ALIGNED, y_min), (LINE + ALIGNED, y_max))
        cubes = [
            Rectangle(name, color, (x - HALF, y - HALF), (x + HALF, y + HALF))
            for name, color, (x, y, _) in zip(
                "abc", COLORS, self.data.site_xpos[self._cubes].tolist(), strict=True
            )
        ]
        table = Rectangle("table", "#e9e7e1", (x_min, y_min), (x_max, y_max))
        return Scene(TABLE, (table, band, *cubes))

    def experts(self) -> tuple[Expert, ...]:
        """One: pushes cube after cube from behind."""
        places = tuple(self.observation_fields[name] for name in CUBES)
        starts = tuple(place.start for place in places if isinstance(place, slice))
        return (Aligner("align", cubes=starts, line=LINE),)

    def _furnish(self) -> None:
        for i in range(len(CUBES)):
            x = LINE - self.np_random.uniform(NEAR, AWAY)
            y = _row(i) + self.np_random.uniform(-0.01, 0.01)
            self.put(f"object{i}:joint", x, y, TOP + HALF)

    def _observe(self) -> Doubles:
        grip, (fingers, opening) = self.grip(), self.fingers()
        moved = self.motion(self._grip)[0]
        parts = [grip, moved, fingers, opening.mean(keepdims=True)]
        for site in self._cubes:
            place = self.data.site_xpos[site]
            turn = euler(self.data.site_xmat[site])
            parts += [place, place - grip, turn, self.motion(site)[0] - moved]
        return np.concatenate(parts)


def _row(cube: int) -> float:
    """y of a cube's place on the line."""
    return START[1] + SPREAD * (cube - 1)


@cache
def _corridor() -> Arm:
    def furnish(spec: Any) -> None:
        for name, x, y, half in (
            ("a", FAR + 0.05, START[1], (0.05, CORRIDOR)),
            ("left", 1.45, START[1] + CORRIDOR + 0.05, (0.35, 0.05)),
            ("right", 1.45, START[1] - CORRIDOR - 0.05, (0.35, 0.05)),
        ):
            paint(spec, name, "#4caf6d" if name == "a" else "#d9534f", (x, y, 0.5), (*half, 0.002))

    return build("reach.xml", furnish)


@cache
def _cubes() -> Arm:
    def furnish(spec: Any) -> None:
        paint(spec, "line", "#f0c244", (LINE, 0.75, TOP), (ALIGNED, 0.35, 0.001))
        for i in range(1, len(CUBES)):
            body = spec.worldbody.add_body(name=f"object{i}", pos=(0, i, 0.5))
            joint = body.add_freejoint(name=f"object{i}:joint")
            joint.damping = spec.joint("object0:joint").damping
            body.add_geom(
                name=f"object{i}",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=(HALF, HALF, HALF),
                condim=3,
                mass=2,
            )
            body.add_site(name=f"object{i}")
        for i, color in enumerate(COLORS):
            block = spec.geom(f"object{i}")
            block.material, block.rgba = "", rgba(color)
            spec.site(f"object{i}").rgba = UNSEEN

    return build("push.xml", furnish, shift=BEHIND)
