"""Scripted experts: phase machines over waypoints, closed-loop, with a number of laps.

An expert is a pure function of what it sees and of its progress, which the caller carries:

    progress = expert.begin(observation, generator)
    while True:
        action, progress = expert.act(observation, progress, generator)
        if progress.done: break
        observation = step(action)

All of them act with noise, so that what they demonstrate is good but not optimal.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

Action = npt.NDArray[Any]
Observation = npt.NDArray[Any]


OUTWARDS = tuple(np.linspace(0.0, 2.0, 17).tolist())
"""How much outward push is tried, in this order, to keep a planned step out of the disc."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far an expert has come.

    `route` is which of its routes it follows, `leg` the waypoint it heads for, `laps` how often it
    has finished the route, `dwelt` for how many steps it has stayed after the last lap, and `pace`
    the share of full speed that it moves with in this episode. `steps` are the actions so far: the
    clock of an expert that moves by the clock. `plan` is what a planner means to do next.
    """

    route: int = 0
    leg: int = 0
    laps: int = 0
    dwelt: int = 0
    pace: float = 1.0
    steps: int = 0
    plan: npt.NDArray[np.float64] | None = field(default=None, compare=False)
    done: bool = False


@runtime_checkable
class Expert(Protocol):
    """What acts like an expert. `name` says which task of the environment it solves."""

    @property
    def name(self) -> str:
        """The task that this expert solves, unique within an environment."""

    @property
    def laps(self) -> int:
        """How many rounds it makes; its progress says how many are behind it."""

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """The progress at the beginning of an episode that starts with `observation`."""

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[Action, Progress]:
        """The next action; if the returned progress is done, nothing is left to do."""


def experts_of(env: object) -> tuple[Expert, ...]:
    """The experts that an environment (single or batched, wrapped or not) publishes.

    An environment publishes them by a method `experts()` on its unwrapped form; empty if it has
    none. Raises TypeError if what it publishes are not experts.
    """
    bare = getattr(env, "unwrapped", env)
    publish = getattr(bare, "experts", None)
    if publish is None:
        return ()
    experts = tuple(publish())
    for expert in experts:
        if not isinstance(expert, Expert):
            raise TypeError(f"{bare!r} publishes {expert!r}, which has no begin() and act()")
    return experts


def advance(progress: Progress, arrived: bool, legs: int, laps: int, dwell: int | None) -> Progress:
    """Progress after a look at whether the waypoint headed for is reached.

    After `laps` rounds of `legs` waypoints it stays `dwell` steps (None: for ever) at the last one.
    """
    if progress.laps == laps:
        dwelt = progress.dwelt + 1
        return replace(progress, dwelt=dwelt, done=dwell is not None and dwelt > dwell)
    if not arrived:
        return progress
    if progress.leg + 1 < legs:
        return replace(progress, leg=progress.leg + 1)
    if progress.laps + 1 < laps:
        return replace(progress, leg=0, laps=progress.laps + 1)
    return replace(progress, laps=laps, done=dwell == 0)


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A place to aim at, reached when the distance is less than `within`."""

    aim: tuple[float, float]
    within: float


@dataclass(frozen=True)
class PointExpert:
    """Steers a point `x' = x + dt·a` along one of its routes, around one disc.

    Of several routes it takes the one whose first waypoint is nearest, by a noisy estimate.
    `clearance` is the radius about the origin that it never plans to enter. Rounds after the first
    lead along `again`, if that is given. The pace of an episode is drawn from `pace`, and each
    action component is disturbed by up to `noise`. Of an observation it sees the first two numbers.
    """

    name: str
    routes: tuple[tuple[Waypoint, ...], ...]
    dt: float
    clearance: float
    laps: int = 1
    dwell: int | None = 0
    again: tuple[Waypoint, ...] = ()
    pace: tuple[float, float] = (0.8, 1.0)
    noise: float = 0.25

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """Choose a route and a pace."""
        x, y = float(observation[0]), float(observation[1])
        distance = [np.hypot(r[0].aim[0] - x, r[0].aim[1] - y) for r in self.routes]
        guess = np.array(distance) * generator.uniform(0.6, 1.4, len(distance))
        return Progress(route=int(guess.argmin()), pace=float(generator.uniform(*self.pace)))

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[Action, Progress]:
        """One step towards the waypoint, the shorter way around the disc."""
        here = np.asarray(observation[:2], np.float64)
        later = self.again and progress.laps > 0 and self.laps > 1
        route = self.again if later else self.routes[progress.route]
        waypoint = route[progress.leg]
        arrived = float(np.linalg.norm(here - waypoint.aim)) < waypoint.within
        progress = advance(progress, arrived, len(route), self.laps, self.dwell)
        aim = _around(here, np.array(route[progress.leg].aim), self.clearance)
        push = np.clip((aim - here) / self.dt, -progress.pace, progress.pace)
        push = np.clip(push + generator.uniform(-self.noise, self.noise, 2), -1.0, 1.0)
        push = self._guarded(here, push)
        return push.astype(np.float32), progress

    def _guarded(
        self, here: npt.NDArray[np.float64], push: npt.NDArray[np.float64]
    ) -> npt.NDArray[np.float64]:
        """The push, turned outwards as far as needed to end outside the disc."""
        outwards = here / max(float(np.linalg.norm(here)), 1e-9)
        for more in OUTWARDS:
            guarded: npt.NDArray[np.float64] = np.clip(push + more * outwards, -1.0, 1.0)
            if float(np.linalg.norm(here + self.dt * guarded)) >= self.clearance:
                return guarded
        return np.asarray(np.clip(2.0 * outwards, -1.0, 1.0))


def _around(
    here: npt.NDArray[np.float64], target: npt.NDArray[np.float64], clearance: float
) -> npt.NDArray[np.float64]:
    """Where to aim from `here` in order to reach `target` without crossing the disc.

    The target itself if the straight line is clear; else a point a little further around.
    """
    line = target - here
    length = float(line @ line)
    nearest = here + line * np.clip(-(here @ line) / max(length, 1e-12), 0.0, 1.0)
    if float(np.linalg.norm(nearest)) >= clearance:
        return target
    angle = np.arctan2(here[1], here[0])
    turn = np.arctan2(target[1], target[0]) - angle
    turn = (turn + np.pi) % (2 * np.pi) - np.pi
    angle += np.clip(turn, -0.6, 0.6)
    return np.array([np.cos(angle), np.sin(angle)]) * max(1.2 * clearance, 1.0)


@dataclass(frozen=True, eq=False)
class GridExpert:
    """Walks shortest paths to one zone after the other; a share `noise` of its steps is random.

    distances  int64 [zones, n]  steps from each cell to each zone, through allowed cells only
    successor  int64 [n, actions]
    allowed    bool [n]  cells it may enter; random steps keep to them too
    corner, height  how an observation (x, y) becomes the number of a cell
    """

    name: str
    distances: npt.NDArray[np.int64]
    successor: npt.NDArray[np.int64]
    allowed: npt.NDArray[np.bool_]
    corner: tuple[int, int]
    height: int
    laps: int = 1
    dwell: int | None = 0
    noise: float = 0.1

    def begin(self, observation: Observation, generator: np.random.Generator) -> Progress:
        """Nothing to choose."""
        return Progress()

    def act(
        self, observation: Observation, progress: Progress, generator: np.random.Generator
    ) -> tuple[Action, Progress]:
        """A step that comes nearer, drawn among the best; or any allowed step."""
        x, y = int(observation[0]) - self.corner[0], int(observation[1]) - self.corner[1]
        cell = x * self.height + y
        arrived = bool(self.distances[progress.leg, cell] == 0)
        progress = advance(progress, arrived, len(self.distances), self.laps, self.dwell)
        reached = self.successor[cell]
        choices = np.flatnonzero(self.allowed[reached])
        distance = self.distances[progress.leg, reached[choices]]
        if progress.laps == self.laps:
            choices = choices[distance == 0]
        elif generator.random() >= self.noise:
            choices = choices[distance == distance.min()]
        return np.asarray(generator.choice(choices)), progress


def grid_distances(
    successor: npt.NDArray[np.int64],
    allowed: npt.NDArray[np.bool_],
    zones: tuple[npt.NDArray[np.bool_], ...],
) -> npt.NDArray[np.int64]:
    """Steps from each cell to each zone through allowed cells, [zones, n]; n if there is no way."""
    count = len(successor)
    rows = []
    for zone in zones:
        distance = np.where(zone & allowed, 0, count)
        while True:
            nearer = np.minimum(distance, distance[successor].min(axis=1) + 1)
            nearer = np.where(allowed, np.minimum(nearer, count), count)
            if (nearer == distance).all():
                break
            distance = nearer
        rows.append(distance)
    return np.array(rows, np.int64)
