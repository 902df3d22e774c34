"""SixteenRooms: a point that walks through the doors of 4×4 rooms (paper, appendix H.1.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box

from tiloilc.tasks.batched import Array, BatchedEnv, SingleEnv
from tiloilc.tasks.experts import Expert, PointExpert, Waypoint
from tiloilc.tasks.finite import FiniteModel
from tiloilc.tasks.scene import Rectangle, Scene

SIDE = 4
"""Rooms along a side; room (i, j) is the i-th from the left and the j-th from below, from 1."""

ROOM, WALL = 8, 2
PITCH = ROOM + WALL
"""A room is ROOM × ROOM between walls that are WALL thick: the next one begins PITCH further on."""

DOOR = 2
"""Width of a door; it is in the middle of each side that two rooms share."""

MARK = 2.0
"""Half the side of the square in the middle of a room that counts as having visited it."""

ARMS = np.array([[(PITCH - DOOR) / 2, WALL / 2], [WALL / 2, (PITCH - DOOR) / 2]])
ARMS.flags.writeable = False
"""Where the walls between four rooms cross is a pillar: from its middle, two walls reach so far."""

EXTENT = SIDE * PITCH - WALL
"""The rooms lie in [0, EXTENT]²."""

START = (1, 1)

NEAR = 0.6
"""Experts have arrived when this near to the middle of a door or a room."""

Room = tuple[int, int]
Corners = tuple[tuple[float, float], tuple[float, float]]

LOOPS: dict[str, tuple[Room, ...]] = {
    "rooms": ((3, 1), (3, 3), (3, 4), (4, 4), (4, 3)),
    "prose": ((3, 3), (3, 4), (4, 4), (4, 3)),
    "large": ((1, 2), (1, 4), (3, 4), (3, 2)),
}
"""Rooms to be visited in this order, again and again: the small loop of the paper's formula, the
small loop as its text has it, and the large one."""


class SixteenRoomsVectorEnv(BatchedEnv):
    """n points in [0, 38]²: `x' = x + a`, a ∈ [-1, 1]², unless a wall is in the way.

    A move whose straight line crosses a wall, or leads out of the rooms, is blocked: the point
    stays where it is, and `hit` is 1 until its next move. Walls do not contain their faces.

    The observation is float32, and all there is to know of the state:

    pos  (x, y); the rooms are 8 × 8, 10 apart, room (1, 1) is [0, 8]²
    hit  1 if the last move was blocked, else 0

    noise  standard deviation of the start about the middle of room (1, 1); it never leaves the room
    """

    def __init__(
        self, num_envs: int = 1, *, noise: float = 0.5, render_mode: str | None = None
    ) -> None:
        if not noise >= 0:
            raise ValueError(f"noise must not be negative, not {noise}")
        super().__init__(
            num_envs,
            Box(np.zeros(3, np.float32), np.array([EXTENT, EXTENT, 1], np.float32)),
            Box(-1.0, 1.0, (2,), np.float32),
            render_mode,
        )
        self.noise = float(noise)
        self.observation_fields = {"pos": slice(0, 2), "hit": 2}

    def scene(self) -> Scene:
        """The walls, and the square in the middle of each room."""
        names = [(i, j) for i in range(1, SIDE + 1) for j in range(1, SIDE + 1)]
        squares = [(f"r{i}{j}", np.array(middle((i, j)))) for i, j in names]
        return Scene(
            (-WALL, -WALL, EXTENT + WALL, EXTENT + WALL),
            (
                *(Rectangle("", "#6b7280", low, high) for low, high in _walls()),
                *(
                    Rectangle(name, "#cfe0f3", _pair(at - MARK), _pair(at + MARK))
                    for name, at in squares
                ),
            ),
        )

    def experts(self) -> tuple[Expert, ...]:
        """One for each loop, which makes two rounds of it by the shortest way."""
        return tuple(_expert(name, loop) for name, loop in LOOPS.items())

    def finite_model(self) -> FiniteModel:
        """A lattice of positions that full actions move between, each hit or not."""
        points = np.arange(EXTENT + 1.0)
        places = np.stack(np.meshgrid(points, points, indexing="ij"), axis=-1).reshape(-1, 2)
        inside = (np.abs(from_pillar(places))[:, None] < ARMS).all(axis=-1)
        places = places[~np.any(inside, axis=-1)]
        states = np.concatenate([np.insert(places, 2, hit, axis=1) for hit in (0, 1)])
        number = {tuple(state): n for n, state in enumerate(states.tolist())}
        steps = (-1.0, 0.0, 1.0)
        actions = np.array([(x, y) for x in steps for y in steps], np.float32)
        before = states.astype(np.float32)
        after = [self._move(before, np.tile(a, (len(states), 1))).tolist() for a in actions]
        return FiniteModel(
            observations=before,
            successor=np.array(
                [[number[tuple(s)] for s in rows] for rows in zip(*after, strict=True)]
            ),
            initial=np.array([number[(*middle(START), 0.0)]], np.int64),
            actions=actions,
            exact=False,
            how=f"dynamic programming on a lattice of {len(places)} positions 1 m apart, begun in "
            "the very middle of the first room: a lower bound, reached by real actions; as no move "
            f"is longer than 1 along either axis, it takes {PITCH - 2 * MARK:g} steps or more from "
            "one room's square to the next",
        )

    def _start(self, copies: npt.NDArray[np.int64]) -> Array:
        start = np.tile(np.array([*middle(START), 0.0]), (len(copies), 1))
        for row, copy in enumerate(copies):
            start[row, :2] += self.generator(int(copy)).normal(0.0, self.noise, 2)
        return np.asarray(np.clip(start, 0.0, ROOM), np.float32)

    def _move(self, state: Array, actions: Array) -> Array:
        if actions.shape != (len(state), 2):
            raise ValueError(f"actions must have shape {(len(state), 2)}, not {actions.shape}")
        here = state[:, :2]
        there = here + np.clip(actions.astype(np.float32), -1.0, 1.0)
        hit = ((there < 0) | (there > EXTENT)).any(axis=1) | crosses(here, there)
        moved = np.empty_like(state)
        moved[:, :2] = np.where(hit[:, None], here, there)
        moved[:, 2] = hit
        return moved

    def _observe(self, state: Array) -> Array:
        return state.copy()

    def _recover(self, observations: Array) -> Array:
        return observations.astype(np.float32)


class SixteenRoomsEnv(SingleEnv):
    """One point in the rooms; see SixteenRoomsVectorEnv."""

    def __init__(self, render_mode: str | None = None, **kwargs: Any) -> None:
        super().__init__(SixteenRoomsVectorEnv(1, render_mode=render_mode, **kwargs))


def middle(room: Room) -> tuple[float, float]:
    """The middle of a room."""
    return PITCH * (room[0] - 1) + ROOM / 2, PITCH * (room[1] - 1) + ROOM / 2


def crosses(
    here: npt.NDArray[np.floating], there: npt.NDArray[np.floating]
) -> npt.NDArray[np.bool_]:
    """Whether the straight lines between points [n, 2] lead through the inside of a wall, [n].

    Lines are no longer than 1 along either axis, so that the walls about one pillar will do.
    """
    start = from_pillar(here)[:, None]
    way = (there.astype(np.float64) - here)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (-ARMS - start) / way, (ARMS - start) / way
    still = way == 0
    enters = np.where(
        still, np.where(np.abs(start) < ARMS, -np.inf, np.inf), np.minimum(one, other)
    )
    leaves = np.where(still, np.inf, np.maximum(one, other))
    first = np.maximum(enters.max(axis=2), 0.0)
    last = np.minimum(leaves.min(axis=2), 1.0)
    return np.asarray((first < last).any(axis=1), np.bool_)


def from_pillar(points: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
    """Points [n, 2] as seen from the nearest pillar."""
    shifted = points.astype(np.float64) + WALL / 2
    return np.asarray(shifted - PITCH * np.round(shifted / PITCH))


def route(rooms: tuple[Room, ...], start: Room) -> tuple[Waypoint, ...]:
    """Middles of doors and rooms on the way from `start` to each of `rooms` in turn.

    As there is a door in every wall between two rooms, each way that never turns back is shortest;
    this one goes along a row first.
    """
    way, (i, j) = [], start
    for room in rooms:
        while (i, j) != room:
            before = np.array(middle((i, j)))
            i, j = (i + _sign(room[0] - i), j) if i != room[0] else (i, j + _sign(room[1] - j))
            after = np.array(middle((i, j)))
            way += [Waypoint(_pair((before + after) / 2), NEAR), Waypoint(_pair(after), NEAR)]
    return tuple(way)


def _expert(name: str, loop: tuple[Room, ...]) -> PointExpert:
    """Walks to the rooms of a loop from where episodes start, and then round once more."""
    first, again = route(loop, START), route(loop, loop[-1])
    return PointExpert(name, (first,), dt=1.0, clearance=0.0, laps=2, again=again)


def _walls() -> list[Corners]:
    """Corners of walls that do not overlap: the frame, and three pieces about each pillar."""
    edge, half, arm = EXTENT + WALL, WALL / 2, (PITCH - DOOR) / 2
    frame = [(-WALL, -WALL, edge, 0), (-WALL, EXTENT, edge, edge)]
    frame += [(-WALL, 0, 0, EXTENT), (EXTENT, 0, edge, EXTENT)]
    pieces = ((-arm, -half, arm, half), (-half, half, half, arm), (-half, -arm, half, -half))
    lines = [PITCH * k - half for k in range(SIDE + 1)]
    pillars = np.array(
        [np.add(piece, (x, y, x, y)) for x in lines for y in lines for piece in pieces]
    )
    inside = np.clip(pillars, 0.0, EXTENT)
    inside = inside[(inside[:, 0] < inside[:, 2]) & (inside[:, 1] < inside[:, 3])]
    return [(_pair(piece[:2]), _pair(piece[2:])) for piece in (*np.array(frame, float), *inside)]


def _pair(point: npt.NDArray[np.floating]) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _sign(number: int) -> int:
    return (number > 0) - (number < 0)
