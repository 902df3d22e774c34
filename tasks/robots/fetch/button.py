"""FetchPlace Button: a block is carried to a goal that moves when a button is pressed."""

from __future__ import annotations

from functools import cache
from typing import Any

import mujoco
import numpy as np

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.known import Known, played
from tiloilc.tasks.robots.base import Doubles, Field
from tiloilc.tasks.robots.fetch.arm import STARTS, TABLE, TOP, Arm, build, rgba
from tiloilc.tasks.robots.fetch.block import GOAL_COLOR, NEAR, WIDE, BlockEnv, plain_block
from tiloilc.tasks.robots.fetch.experts import Presser
from tiloilc.tasks.scene import Circle, Rectangle, Scene

GOAL_FROM, GOAL_TO = (1.22, 0.58, 0.45), (1.44, 0.80, 0.62)
"""The box that the goals of FetchPlace Button are drawn from: over the table."""

BUTTON_FROM, BUTTON_TO = (1.22, 0.93), (1.42, 1.0)
BUTTON_Z = 0.46
"""How high the gripper presses the button: a block in it stays clear of the table."""

BUTTON_COLOR = "#4caf6d"


class FetchPlaceButtonEnv(BlockEnv):
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
        """The table, the goal, the button and the block; where they may be, before a reset."""
        table, block = self.ground()
        goal, button = self._goal.tolist(), self._button.tolist()
        reach: tuple[Circle | Rectangle, ...] = (
            Rectangle("GoalReached", GOAL_COLOR, GOAL_FROM[:2], GOAL_TO[:2]),
            Rectangle("ButtonReached", BUTTON_COLOR, BUTTON_FROM, BUTTON_TO),
        )
        if self._begun:
            reach = (
                Circle("GoalReached", GOAL_COLOR, (goal[0], goal[1]), NEAR),
                Circle("ButtonReached", BUTTON_COLOR, (button[0], button[1]), NEAR),
            )
        return Scene(TABLE, (table, *reach, block))

    def experts(self) -> tuple[Expert, ...]:
        """One: keeps the block in hand, two rounds of goal and button."""
        return (Presser("button", laps=2),)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """The expert without noise and in a hurry, from a few starts."""
        how = (
            "a scripted controller with the block in hand: a lower bound, reached by real actions "
            f"from {STARTS} starts"
        )
        expert = Presser("button", laps=horizon, noise=0.0, near=0.98 * NEAR)
        return (played(FetchPlaceButtonEnv(), expert, horizon, STARTS, how),)

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


@cache
def _with_button() -> Arm:
    def furnish(spec: Any) -> None:
        plain_block(spec)
        goal = spec.worldbody.add_body(name="goal", mocap=True)
        goal.add_site(
            name="goal",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=(NEAR, 0, 0),
            rgba=rgba(GOAL_COLOR, 0.4),
        )
        button = spec.worldbody.add_body(name="button", mocap=True)
        button.add_site(
            name="button",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            pos=(0, 0, (TOP - BUTTON_Z) / 2),
            size=(0.03, (BUTTON_Z - TOP) / 2, 0),
            rgba=rgba(BUTTON_COLOR, 0.6),
        )

    return build("pick_and_place.xml", furnish)
