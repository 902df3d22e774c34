"""Fetch Align: three cubes are pushed onto a line."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.known import Known, played
from tiloilc.tasks.robots.base import Doubles, Field
from tiloilc.tasks.robots.fetch.arm import (
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
from tiloilc.tasks.robots.fetch.experts import Aligner
from tiloilc.tasks.scene import Rectangle, Scene

LINE = 1.30
"""x of the line across the middle of the table."""

ALIGNED = 0.03
"""A cube is on the line if its middle is nearer than this, in metres."""

SPREAD = 0.12
"""Metres between neighbouring cubes, along the line."""

NEAR, AWAY = 0.05, 0.08
"""How far from the line a cube begins at least and at most: all on the robot's side."""

SHIFT = 0.01
"""How far along the line from its place a cube begins at most."""

BEHIND = (-0.19, -SPREAD, -0.1)
"""From where the gripper usually begins to where it does here: low, behind the first cube."""

CUBES = ("cube1", "cube2", "cube3")
COLORS = ("#d9534f", "#4caf6d", "#5b8fd6")


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
        """The table, the line in its middle, and the cubes; where they may be, before a reset."""
        x_min, y_min, x_max, y_max = TABLE
        shapes = [
            Rectangle("", "#e9e7e1", (x_min, y_min), (x_max, y_max)),
            Rectangle("line", "#f0e2b6", (LINE - ALIGNED, y_min), (LINE + ALIGNED, y_max)),
        ]
        for i, (site, color) in enumerate(zip(self._cubes, COLORS, strict=True)):
            if self._begun:
                x, y, _ = self.data.site_xpos[site].tolist()
                low, high = (x - HALF, y - HALF), (x + HALF, y + HALF)
            else:
                low = LINE - AWAY - HALF, _row(i) - SHIFT - HALF
                high = LINE - NEAR + HALF, _row(i) + SHIFT + HALF
            shapes.append(Rectangle("abc"[i], color, low, high))
        return Scene(TABLE, tuple(shapes))

    def experts(self) -> tuple[Expert, ...]:
        """One: pushes cube after cube from behind."""
        return (self._expert(),)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """The expert without noise, from a few starts."""
        how = (
            "a scripted controller that pushes one cube after the other: a lower bound, reached by "
            "real actions from 8 starts"
        )
        expert = replace(self._expert(), noise=0.0, dwell=horizon)
        return (played(FetchAlignEnv(), expert, horizon, 8, how),)

    def _expert(self) -> Aligner:
        places = tuple(self.observation_fields[name] for name in CUBES)
        starts = tuple(place.start for place in places if isinstance(place, slice))
        return Aligner("align", cubes=starts, line=LINE)

    def _furnish(self) -> None:
        for i in range(len(CUBES)):
            x = LINE - self.np_random.uniform(NEAR, AWAY)
            y = _row(i) + self.np_random.uniform(-SHIFT, SHIFT)
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
