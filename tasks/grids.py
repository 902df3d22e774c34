"""The three grid worlds (paper, appendix H.1.1): a corridor, a row of squares, a cross."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Discrete, MultiDiscrete

from tiloilc.tasks.batched import Array, BatchedEnv, SingleEnv
from tiloilc.tasks.experts import Expert, GridExpert, grid_distances
from tiloilc.tasks.finite import FiniteModel
from tiloilc.tasks.scene import Rectangle, Scene

MOVES = ((1, 0), (0, 1), (-1, 0), (0, -1), (0, 0))
"""What actions 0 to 4 do to (x, y): east, north, west, south, stay."""

ZONE_COLORS = ("#f0c244", "#4caf6d", "#d9534f", "#9b6fc4", "#e08a3c")
OBSTACLE_COLOR = "#6b7280"
HAZARD_COLOR = "#b8cbe8"

SQUARE = 7
"""Cells along a side of the squares that sequential and circular worlds are made of."""

NAMES = "abcde"


@dataclass(frozen=True)
class Region:
    """A rectangle of cells, both corners included."""

    name: str
    low: tuple[int, int]
    high: tuple[int, int]

    def contains(self, cells: npt.NDArray[np.integer]) -> npt.NDArray[np.bool_]:
        """Which of cells [n, 2] it holds."""
        inside = (cells >= np.array(self.low)) & (cells <= np.array(self.high))
        return np.asarray(inside.all(axis=-1), np.bool_)

    def drawn(self, color: str) -> Rectangle:
        """The region as a shape: cell (x, y) is drawn as the unit square around (x, y)."""
        return Rectangle(
            self.name,
            color,
            (self.low[0] - 0.5, self.low[1] - 0.5),
            (self.high[0] + 0.5, self.high[1] + 0.5),
        )


@dataclass(frozen=True)
class Grid:
    """A rectangle of cells, some of them blocked.

    `zones` are to be visited in this order; `hazards` can be entered but should not; `walls`
    cannot be entered. Cells are numbered x first: n = (x - x_min) · height + (y - y_min).
    """

    whole: Region
    start: tuple[int, int]
    zones: tuple[Region, ...]
    hazards: tuple[Region, ...] = ()
    walls: tuple[Region, ...] = ()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, in cells."""
        (x, y), (to_x, to_y) = self.whole.low, self.whole.high
        return to_x - x + 1, to_y - y + 1

    @cached_property
    def cells(self) -> npt.NDArray[np.int64]:
        """(x, y) of each cell, [n, 2]."""
        width, height = self.size
        number = np.arange(width * height)
        cells = np.stack([number // height, number % height], axis=-1)
        return np.asarray(cells + np.array(self.whole.low), np.int64)

    @cached_property
    def blocked(self) -> npt.NDArray[np.bool_]:
        """Which cells are walls, [n]."""
        return self.any_of(self.walls)

    @cached_property
    def successor(self) -> npt.NDArray[np.int64]:
        """The cell after each action, [n, 5]; a move into a wall or out of the grid is none."""
        target = self.cells[:, None, :] + np.array(MOVES)
        inside = self.whole.contains(target)
        number = np.where(inside, self.number(np.where(inside[..., None], target, 0)), 0)
        free = inside & ~self.blocked[number]
        return np.where(free, number, np.arange(len(self.cells))[:, None])

    def any_of(self, regions: tuple[Region, ...]) -> npt.NDArray[np.bool_]:
        """Which cells lie in one of `regions`, [n]."""
        member = np.zeros(len(self.cells), np.bool_)
        for region in regions:
            member |= region.contains(self.cells)
        return member

    def number(self, cells: npt.NDArray[np.integer]) -> npt.NDArray[np.int64]:
        """The numbers of cells […, 2]."""
        offset = cells - np.array(self.whole.low)
        return np.asarray(offset[..., 0] * self.size[1] + offset[..., 1], np.int64)


class GridVectorEnv(BatchedEnv):
    """n walkers on a grid; five actions (see MOVES); the observation is (x, y), int64.

    `tour` names what there is to do; a `cyclic` one goes on with the first zone after the last.
    """

    def __init__(
        self, grid: Grid, num_envs: int, render_mode: str | None, *, tour: str, cyclic: bool = False
    ) -> None:
        space = MultiDiscrete(list(grid.size), start=list(grid.whole.low))
        super().__init__(num_envs, space, Discrete(len(MOVES)), render_mode)
        self.grid, self.tour, self.cyclic = grid, tour, cyclic
        self.observation_fields = {"x": 0, "y": 1}

    def scene(self) -> Scene:
        """Hazards and walls, then the zones over them."""
        outer = self.grid.whole.drawn("")
        shapes = [region.drawn(HAZARD_COLOR) for region in self.grid.hazards]
        shapes += [region.drawn(OBSTACLE_COLOR) for region in self.grid.walls]
        shapes += [
            zone.drawn(ZONE_COLORS[i % len(ZONE_COLORS)]) for i, zone in enumerate(self.grid.zones)
        ]
        return Scene((*outer.low, *outer.high), tuple(shapes))

    def experts(self) -> tuple[Expert, ...]:
        """One that visits the zones in order: twice if they form a cycle, else to stay there."""
        allowed = ~self.grid.blocked & ~self.grid.any_of(self.grid.hazards)
        zones = tuple(zone.contains(self.grid.cells) for zone in self.grid.zones)
        expert = GridExpert(
            name=self.tour,
            distances=grid_distances(self.grid.successor, allowed, zones),
            successor=self.grid.successor,
            allowed=allowed,
            corner=self.grid.whole.low,
            height=self.grid.size[1],
            laps=2 if self.cyclic else 1,
            dwell=0 if self.cyclic else 3,
        )
        return (expert,)

    def finite_model(self) -> FiniteModel:
        """The grid itself."""
        return FiniteModel(
            observations=self.grid.cells.copy(),
            successor=self.grid.successor.copy(),
            initial=self.grid.number(np.array([self.grid.start])),
            actions=np.arange(len(MOVES)),
            exact=True,
            how=f"dynamic programming on all {len(self.grid.cells)} cells: exact",
        )

    def _start(self, copies: npt.NDArray[np.int64]) -> Array:
        return np.full(len(copies), self.grid.number(np.array(self.grid.start)), np.int64)

    def _move(self, state: Array, actions: Array) -> Array:
        if actions.shape != state.shape or actions.dtype.kind not in "iu":
            raise ValueError(f"actions must be {len(state)} whole numbers, one a copy")
        if ((actions < 0) | (actions >= len(MOVES))).any():
            raise ValueError(f"actions must lie in 0 … {len(MOVES) - 1}")
        return np.asarray(self.grid.successor[state, actions])

    def _observe(self, state: Array) -> Array:
        return np.asarray(self.grid.cells[state])

    def _recover(self, observations: Array) -> Array:
        return self.grid.number(observations.astype(np.int64))


class GridAvoidVectorEnv(GridVectorEnv):
    """A corridor y = 0 from (0, 0): zone a begins `distance` cells on, beside it is hazard z."""

    def __init__(
        self, num_envs: int = 1, *, distance: int = 7, render_mode: str | None = None
    ) -> None:
        if distance < 1:
            raise ValueError(f"distance must be at least 1, not {distance}")
        end = distance + 10
        grid = Grid(
            whole=Region("grid", (0, -3), (end, 3)),
            start=(0, 0),
            zones=(Region("a", (distance, 0), (end, 0)),),
            hazards=(Region("z", (0, -3), (end, -1)), Region("z", (0, 1), (end, 3))),
        )
        super().__init__(grid, num_envs, render_mode, tour="avoid")


class GridSequentialVectorEnv(GridVectorEnv):
    """Squares of 7×7 cells in a row, start in the middle of the first, then zones a, b, c, …"""

    def __init__(
        self, num_envs: int = 1, *, zones: int = 3, render_mode: str | None = None
    ) -> None:
        if not 1 <= zones <= len(NAMES):
            raise ValueError(f"zones must be 1 to {len(NAMES)}, not {zones}")
        grid = Grid(
            whole=Region("grid", (0, 0), (SQUARE * (zones + 1) - 1, SQUARE - 1)),
            start=(SQUARE // 2, SQUARE // 2),
            zones=tuple(
                Region(name, (SQUARE * i, 0), (SQUARE * (i + 1) - 1, SQUARE - 1))
                for i, name in enumerate(NAMES[:zones], start=1)
            ),
        )
        super().__init__(grid, num_envs, render_mode, tour="sequential")


class GridCircularVectorEnv(GridVectorEnv):
    """A cross of five 7×7 squares: the middle blocked, zones a, b, c, d east, north, west, south.

    zones    how many of the four are named (the paper's difficulty)
    core     cells along a side of a zone, in the middle of its square; odd, at most 7
    corners  whether the canvas around the cross is open; if not, the squares only meet around the
             obstacle, which then is 5×5

    The walk begins in the south-east corner of the canvas, one square before a.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        zones: int = 2,
        core: int = 5,
        corners: bool = True,
        render_mode: str | None = None,
    ) -> None:
        if not 2 <= zones <= 4:
            raise ValueError(f"zones must be 2 to 4, not {zones}")
        if core not in (1, 3, 5, 7):
            raise ValueError(f"core must be 1, 3, 5 or 7, not {core}")
        far = 3 * SQUARE - 1
        squares = ((2, 1), (1, 2), (0, 1), (1, 0))
        margin = 0 if corners else 1
        walls = [Region("z", (SQUARE + margin,) * 2, (2 * SQUARE - 1 - margin,) * 2)]
        if not corners:
            walls += [_square("wall", (i, j), SQUARE) for i in (0, 2) for j in (0, 2)]
        grid = Grid(
            whole=Region("grid", (0, 0), (far, far)),
            start=(far, 0) if corners else (2 * SQUARE, SQUARE),
            zones=tuple(
                _square(NAMES[i], square, core) for i, square in enumerate(squares[:zones])
            ),
            walls=tuple(walls),
        )
        super().__init__(grid, num_envs, render_mode, tour="circular", cyclic=True)


class GridAvoidEnv(SingleEnv):
    """One walker in the corridor; see GridAvoidVectorEnv."""

    def __init__(self, render_mode: str | None = None, **kwargs: Any) -> None:
        super().__init__(GridAvoidVectorEnv(1, render_mode=render_mode, **kwargs))


class GridSequentialEnv(SingleEnv):
    """One walker on the row of squares; see GridSequentialVectorEnv."""

    def __init__(self, render_mode: str | None = None, **kwargs: Any) -> None:
        super().__init__(GridSequentialVectorEnv(1, render_mode=render_mode, **kwargs))


class GridCircularEnv(SingleEnv):
    """One walker around the cross; see GridCircularVectorEnv."""

    def __init__(self, render_mode: str | None = None, **kwargs: Any) -> None:
        super().__init__(GridCircularVectorEnv(1, render_mode=render_mode, **kwargs))


def _square(name: str, square: tuple[int, int], size: int) -> Region:
    """The middle size×size cells of the square in column i and row j of the 3×3 squares."""
    margin = (SQUARE - size) // 2
    low = (SQUARE * square[0] + margin, SQUARE * square[1] + margin)
    return Region(name, low, (low[0] + size - 1, low[1] + size - 1))
