"""Fetch Avoid: the arm stretches out and does not swerve."""

from __future__ import annotations

from functools import cache
from math import ceil
from typing import Any

import numpy as np

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.known import Known, played
from tiloilc.tasks.robots.base import Doubles, Field
from tiloilc.tasks.robots.fetch.arm import (
    FINGERS,
    GRIP_VELOCITY,
    REACH,
    START,
    TABLE,
    Arm,
    FetchEnv,
    build,
    paint,
)
from tiloilc.tasks.robots.fetch.experts import Reacher
from tiloilc.tasks.scene import Rectangle, Scene

FAR = 1.70
"""x from which on the arm counts as stretched out, in metres; it reaches 1.78."""

AIM = (FAR + 0.04, START[1], 0.535)
"""Where an expert goes."""

CORRIDOR = 0.04
"""How far the gripper may leave its first y to either side."""


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
                Rectangle("", "#e9e7e1", (x_min, y_min), (x_max, y_max)),
                Rectangle("z", "#efc7c5", (x_min, y_min), (1.85, right)),
                Rectangle("z", "#efc7c5", (x_min, left), (1.85, y_max)),
                Rectangle("a", "#4caf6d", (FAR, right), (1.85, left)),
            ),
        )

    def experts(self) -> tuple[Expert, ...]:
        """One: straight on."""
        return (Reacher("avoid", dwell=10, aim=AIM, arrived=FAR),)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """The expert without noise, from the one start there is."""
        steps = ceil((FAR - START[0]) / REACH)
        how = (
            "a scripted controller that goes straight on: a lower bound, reached by real actions; "
            f"a step asks for at most {REACH:g} m, so that nobody arrives before step {steps}"
        )
        expert = Reacher("avoid", noise=0.0, dwell=horizon, aim=AIM, arrived=FAR)
        return (played(FetchAvoidEnv(), expert, horizon, 1, how),)

    def _observe(self) -> Doubles:
        fingers, opening = self.fingers()
        return np.concatenate([self.grip(), fingers, self.motion(self._grip)[0], opening])


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
