"""An arm and a block to be taken: what the two FetchPlace tasks share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tiloilc.tasks.robots.base import Doubles, Field
from tiloilc.tasks.robots.fetch.arm import (
    FINGERS,
    GRIP_VELOCITY,
    HALF,
    TABLE,
    TOP,
    UNSEEN,
    Arm,
    FetchEnv,
    euler,
    rgba,
)
from tiloilc.tasks.scene import Rectangle

Pair = tuple[float, float]

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

NEAR = 0.05
"""Metres from a block to the goal, or from the gripper to the button, that count as there."""

GOAL_COLOR = "#d9534f"
BLOCK_COLOR = "#5b5b66"


class BlockEnv(FetchEnv):
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

    def ground(self) -> tuple[Rectangle, Rectangle]:
        """The table and the block; where that may be, before a reset."""
        low, high = BLOCK_FROM, BLOCK_TO
        if self._begun:
            x, y, _ = self.block().tolist()
            low = high = (x, y)
        return (
            Rectangle("", "#e9e7e1", TABLE[:2], TABLE[2:]),
            Rectangle("block", BLOCK_COLOR, *grown(low, high, HALF)),
        )


def grown(low: Pair, high: Pair, by: float) -> tuple[Pair, Pair]:
    """A rectangle and what is less than `by` beside it."""
    return (low[0] - by, low[1] - by), (high[0] + by, high[1] + by)


def plain_block(spec: Any) -> None:
    """Let the block be of one colour, without the mark in its middle."""
    spec.geom("object0").material, spec.geom("object0").rgba = "", rgba(BLOCK_COLOR)
    spec.site("object0").rgba = UNSEEN
