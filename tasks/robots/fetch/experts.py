"""Scripted experts of the Fetch tasks: the gripper is steered to one point after another.

They are pure functions of the observation and of their progress, as `tiloilc.tasks.experts` says.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tiloilc.tasks.experts import Action, Observation, Progress

Doubles = npt.NDArray[np.float64]
Wish = tuple[Doubles, float, Progress]
"""Where the gripper shall be, whether it opens (1) or closes (-1), and the progress."""

GAIN = 25.0
"""Of an action for each metre to go: a full action moves the gripper by 33 mm, not by the 50 that
it asks for, so that this is a little less than what would arrive in one step."""

ASIDE = 0.008
"""Metres beside a cube's middle from which it can still be pushed straight."""

BEHIND = 0.045
"""Metres from a cube's middle to that of a gripper that may move freely behind it."""

CONTACT = 0.04
"""Metres from a cube's middle to that of the gripper that pushes it."""

LOW = 0.43
"""z of a gripper that pushes, or that puts a block down."""

CARRYING = 0.50
"""z of a gripper that carries a block over a tray's rim."""

PLACED = 0.025
"""Metres from the middle of where a block belongs at which it is let go."""


@dataclass(frozen=True)
class Steered:
    """An expert that wishes where to go; each component of an action is off by up to `noise`.

    `dwell` is for how many steps it stays when all is done.
    """

    name: str
    laps: int = 1
    dwell: int = 3
    noise: float = 0.2

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """Nothing to choose."""
        return Progress()

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[Action, Progress]:
        """One step towards what it wishes."""
        seen = np.asarray(observation, np.float64)
        aim, fingers, progress = self._wish(seen, progress)
        if progress.laps == self.laps:
            stayed = progress.dwelt >= self.dwell
            progress = replace(progress, dwelt=progress.dwelt + 1, done=stayed)
        push = np.clip(GAIN * (aim - seen[:3]), -1.0, 1.0)
        push += generator.uniform(-self.noise, self.noise, 3)
        return np.clip([*push, fingers], -1.0, 1.0).astype(np.float32), progress

    @abstractmethod
    def _wish(self, seen: Doubles, progress: Progress) -> Wish:
        """What it would do without noise."""


@dataclass(frozen=True)
class Reacher(Steered):
    """Goes straight to `aim`; it has arrived where x is at least `arrived`."""

    aim: tuple[float, float, float] = (0.0, 0.0, 0.0)
    arrived: float = 0.0

    def _wish(self, seen: Doubles, progress: Progress) -> Wish:
        if seen[0] >= self.arrived:
            progress = replace(progress, laps=self.laps)
        return np.array(self.aim), 0.0, progress


@dataclass(frozen=True)
class Aligner(Steered):
    """Pushes cubes along x onto `line`, one after the other, from behind.

    `cubes` is where in the observation the x, y, z of each cube begin; `progress.leg` is the cube.
    """

    cubes: tuple[int, ...] = ()
    line: float = 0.0

    def _wish(self, seen: Doubles, progress: Progress) -> Wish:
        grip = seen[:3]
        if progress.laps == self.laps:
            return grip - np.array((0.05, 0.0, 0.0)), 0.0, progress
        if abs(seen[self.cubes[progress.leg]] - self.line) < 0.02:
            progress = replace(progress, leg=progress.leg + 1)
            if progress.leg == len(self.cubes):
                return self._wish(seen, replace(progress, laps=self.laps))
        x, y = seen[self.cubes[progress.leg] :][:2]
        across = y - grip[1]
        if abs(across) < ASIDE:
            return np.array([self._pushing(grip[0], x), y, LOW]), 0.0, progress
        if grip[0] < x - BEHIND:
            return np.array([x - BEHIND - 0.01, y, LOW]), 0.0, progress
        sideways = grip[1] + np.clip(across, -0.03, 0.03)  # back first: another cube stands there
        return np.array([x - BEHIND - 0.02, sideways, LOW]), 0.0, progress

    def _pushing(self, grip: float, cube: float) -> float:
        """The x to aim at: slower and slower with the cube, or it slides on over the line."""
        if cube - grip < BEHIND:
            return grip + (10 * (self.line - cube) + 0.2) / GAIN
        return self.line - CONTACT


@dataclass(frozen=True)
class Carrier(Steered):
    """Takes the block, and then carries it about.

    Seen are the gripper, the block, the way from one to the other, and the two fingers, in this
    order.
    """

    def _wish(self, seen: Doubles, progress: Progress) -> Wish:
        if progress.laps == self.laps or holds(seen):
            return self._carry(seen, progress)
        block, away = seen[3:6], seen[6:9]
        beside = float(np.hypot(away[0], away[1]))
        if beside > 0.02 and away[2] > -0.06:  # up, before it goes across
            return np.array([*seen[:2], block[2] + 0.08]), 1.0, progress
        if beside > 0.01:
            return np.array([*block[:2], block[2] + 0.07]), 1.0, progress
        return block.copy(), -1.0 if abs(away[2]) < 0.012 else 1.0, progress

    @abstractmethod
    def _carry(self, seen: Doubles, progress: Progress) -> Wish:
        """The wish while the block is held, and when all is done."""


@dataclass(frozen=True)
class Placer(Carrier):
    """Puts the block into the tray if there is one, else to `goal` on the table, and lets go."""

    goal: tuple[float, float] = (0.0, 0.0)

    def _carry(self, seen: Doubles, progress: Progress) -> Wish:
        grip, block, away = seen[:3].copy(), seen[3:6], seen[6:9]
        if progress.laps == self.laps:
            grip[2] += 0.02 if progress.dwelt > 1 else 0.0  # open first, then up
            return grip, 1.0, progress
        aim = seen[25:27] if seen[27] > 0.5 else np.array(self.goal)
        off = float(np.linalg.norm(block[:2] - aim))
        if off < PLACED and block[2] < 0.445:
            return grip, 1.0, replace(progress, laps=self.laps)
        if off > 0.06 and block[2] < 0.47:  # up, over the rim
            return np.array([*grip[:2], CARRYING]), -1.0, progress
        return np.array([*(aim - away[:2]), LOW if off < PLACED else CARRYING]), -1.0, progress


@dataclass(frozen=True)
class Presser(Carrier):
    """Carries the block to the goal, then, block in hand, goes to the button; and again.

    It turns round where the block is nearer to the goal than `near`, in metres.
    """

    near: float = 0.035

    def _carry(self, seen: Doubles, progress: Progress) -> Wish:
        grip, block, away = seen[:3], seen[3:6], seen[6:9]
        goal, button = seen[25:28], seen[28:31]
        if progress.laps == self.laps:
            return grip.copy(), -1.0, progress
        if progress.leg == 0 and np.linalg.norm(block - goal) < self.near:
            progress = replace(progress, leg=1)
        elif progress.leg == 1 and np.linalg.norm(grip - button) < 0.05:
            progress = replace(progress, leg=0, laps=progress.laps + 1)
        return (goal - away if progress.leg == 0 else button.copy()), -1.0, progress


def holds(seen: Doubles) -> bool:
    """Whether the closed fingers have the block between them."""
    return bool(np.linalg.norm(seen[6:9]) < 0.03 and seen[9:11].sum() < 0.053)
