"""Who drives in Carlo: a good driver, a careless one, and one in a hurry."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tiloilc.tasks.carlo.road import (
    AXLE,
    CENTER_LINE,
    FRICTION,
    MAX_SPEED,
    MIDDLE,
    REGION,
    REGIONS,
    RING,
    SIZE,
)
from tiloilc.tasks.experts import Action, Observation, Progress, advance

RETURN = 0.15
"""Slope, per metre of offset, at which a driver comes back to the line."""

TURN = 0.25
"""Curvature, in 1/m, per radian that the car does not look where it should."""

EASE = 0.5
"""Seconds in which a driver wants to have the wanted speed."""

OUT, ABOUT = 0.95, 2.5
"""Seconds in which a car in a hurry turns out, and then round."""

LINES = ((16.2, 0.4), (16.7, 0.0))
"""Radii of inner lines, m, and how much farther out they are at the regions: for these do not reach
the disc, and a fast car is seen in them only once or twice. A local search found the first line and
the seconds: for the usual start they make one round more than the second line, a plain circle.
"""


@dataclass(frozen=True, slots=True)
class Seen:
    """What an observation says: radius and angle about the middle, speed, heading; m, rad, m/s."""

    radius: float
    around: float
    speed: float
    heading: float

    @staticmethod
    def of(observation: Observation, *, angle: bool) -> Seen:
        """Read one; `angle` says that the heading is given as ψ / 2π."""
        x, y, vx, vy, *heading = np.asarray(observation, np.float64).tolist()
        x, y = SIZE * x - MIDDLE, SIZE * y - MIDDLE
        looks = 2 * np.pi * heading[0] if angle else np.arctan2(heading[1], heading[0])
        return Seen(
            float(np.hypot(x, y)),
            float(np.arctan2(y, x)),
            float(MAX_SPEED * np.hypot(vx, vy)),
            float(looks),
        )


def steering(seen: Seen, radius: float, sense: int) -> float:
    """The steering angle δ that keeps to a circle about the middle, or leads back to it.

    `sense` is 1 with the direction of the road, counter-clockwise, else -1. On the circle a car of
    the kinematic bicycle looks outwards by its slip β, sin β = AXLE / radius: this is fed forward.
    An offset e asks for a course that is turned inwards by atan(RETURN · e), and an error of the
    heading for curvature: as the heading is the rate of the offset, P and D of one controller.
    """
    course = seen.around + sense * (np.pi / 2 + np.arctan(RETURN * (seen.radius - radius)))
    error = course - sense * np.arcsin(AXLE / radius) - seen.heading
    error = (error + np.pi) % (2 * np.pi) - np.pi
    slip = np.arcsin(np.clip(AXLE * (sense / radius + TURN * error), -0.9, 0.9))
    return float(np.clip(np.arctan(2 * np.tan(slip)), -1.0, 1.0))


def throttle(seen: Seen, speed: float) -> float:
    """The throttle u, in m/s², that leads to `speed` in EASE seconds, as far as it can."""
    return float(np.clip(FRICTION + (speed - seen.speed) / EASE, -1.0, 1.0))


@dataclass(frozen=True)
class Driver:
    """Follows the centre line through both regions, `laps` times, and is done.

    angle  whether it sees the heading as ψ / 2π
    speed  the speed of an episode is drawn from this range, m/s
    noise  steering in rad and throttle in m/s² are disturbed at each step by up to this
    """

    name: str
    angle: bool = False
    laps: int = 2
    speed: tuple[float, float] = (8.0, 10.0)
    noise: float = 0.2

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """Choose a speed; the pace is its share of the greatest."""
        return Progress(pace=float(generator.uniform(*self.speed)) / MAX_SPEED)

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[Action, Progress]:
        """Steer along the line and keep the speed."""
        seen = Seen.of(observation, angle=self.angle)
        progress = advance(progress, self._arrived(seen, progress.leg), len(REGIONS), self.laps, 0)
        wanted = steering(seen, CENTER_LINE, 1), throttle(seen, progress.pace * MAX_SPEED)
        action = np.array(wanted) + generator.uniform(-self.noise, self.noise, 2)
        return np.clip(action, -1.0, 1.0).astype(np.float32), progress

    def _arrived(self, seen: Seen, leg: int) -> bool:
        """Whether the car is in the region that it heads for."""
        x, y = REGIONS[leg]
        here = MIDDLE + seen.radius * np.array([np.cos(seen.around), np.sin(seen.around)])
        return bool(np.hypot(here[0] - x, here[1] - y) < REGION)


@dataclass(frozen=True)
class CarelessDriver(Driver):
    """Drives as the good one does until it lets go of the wheel, or its demonstration ends early.

    What it shows is unsafe or incomplete, and never a whole round (appendix F.3).

    crashes  it lets go after so many steps, drawn from this range, or …
    ends     … ends after so many: it has seen the first region then, but not the second
    """

    laps: int = 1
    crashes: tuple[int, int] = (60, 210)
    ends: tuple[int, int] = (170, 210)

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """Choose a speed and what goes wrong: route 0 is unsafe, 1 incomplete; leg says when."""
        route = int(generator.random() < 0.5)
        when = int(generator.integers(*(self.crashes, self.ends)[route]))
        return replace(super().begin(observation, generator), route=route, leg=when)

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[Action, Progress]:
        """As the good driver; later straight on, until the car is well inside the ring."""
        action, _ = super().act(observation, replace(progress, leg=0), generator)
        over = progress.dwelt >= progress.leg
        if over and progress.route == 0:
            action = np.array([0.0, action[1]], np.float32)
        beyond = Seen.of(observation, angle=self.angle).radius > RING
        done = over and (progress.route == 1 or beyond)
        return action, replace(progress, dwelt=progress.dwelt + 1, laps=int(done), done=done)


def racing(
    seconds: float, observation: Observation, *, angle: bool, line: tuple[float, float], sense: int
) -> Action:
    """The best drives that are known: an inner line at full throttle all the way.

    With `sense` -1 the car first turns round, for the first region is near behind: out for a
    moment, then a U-turn inwards. `line` is one of LINES.
    """
    seen = Seen.of(observation, angle=angle)
    if sense < 0 and seconds < OUT:
        steer = -0.8
    elif sense < 0 and seconds < OUT + ABOUT:
        steer = 1.0
    else:
        steer = steering(seen, line[0] + line[1] * abs(np.cos(seen.around)) ** 8, sense)
    return np.array([steer, 1.0], np.float32)
