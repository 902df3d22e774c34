"""FlatWorld: a point among four discs in the plane (paper, appendix H.1.2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box

from tiloilc.tasks.batched import Array, BatchedEnv, SingleEnv
from tiloilc.tasks.experts import Expert, PointExpert, Waypoint
from tiloilc.tasks.finite import FiniteModel
from tiloilc.tasks.scene import Circle, Scene

DT = 0.4
"""Metres a full action moves. The paper's text has 0.1 and actions in [0, 1], which could never go
left or down; only 0.4 makes its table's 47 of 50 steps in yellow possible."""

BOUND = 2.0
START = (-1.0, -1.0)

RED = Circle("r", "#d9534f", (0.45, -0.75), 0.3)
GREEN = Circle("g", "#4caf6d", (0.45, 1.0), 0.3)
YELLOW = Circle("y", "#f0c244", (-0.85, 0.15), 0.3)
BLUE = Circle("b", "#5b8fd6", (0.0, 0.0), 0.8)
DISCS = (RED, GREEN, YELLOW, BLUE)
"""A state is in a disc iff its distance from the centre is less than the radius. Blue overlaps the
inner parts of red and yellow: there a state is in two."""

CLEARANCE = 0.85
"""Experts keep this far from the middle of blue: its radius and a margin."""

AT_RED = Waypoint((0.5, -0.85), 0.17)
AT_GREEN = Waypoint((0.45, 0.95), 0.2)
AT_YELLOW = Waypoint((-0.9, 0.2), 0.2)
"""Well inside each disc, and away from blue."""

LATTICE_STEPS = 4
"""Lattice points that a full action moves: 0.1 m apart at the usual dt."""

LATTICE_MARGIN = 1e-3
"""Lattice points nearer than this to a disc's rim are left out, so that rounding along a path
(about 1e-6 in 50 steps of float32) never decides what a state is in."""


class FlatWorldVectorEnv(BatchedEnv):
    """n points in [-2, 2]²: `x' = clip(x + dt·a)`, a ∈ [-1, 1]²; the observation is x, float32.

    dt            how far a full action moves, in metres
    random_start  begin anywhere outside all discs instead of in (-1, -1)
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        dt: float = DT,
        random_start: bool = False,
        render_mode: str | None = None,
    ) -> None:
        if not dt > 0:
            raise ValueError(f"dt must be positive, not {dt}")
        super().__init__(
            num_envs,
            Box(-BOUND, BOUND, (2,), np.float32),
            Box(-1.0, 1.0, (2,), np.float32),
            render_mode,
        )
        self.dt = float(dt)
        self.random_start = random_start
        self.observation_fields = {"pos": slice(0, 2)}

    def scene(self) -> Scene:
        """The three discs to be visited, and blue over them: what it covers is lost."""
        return Scene((-BOUND, -BOUND, BOUND, BOUND), DISCS)

    def experts(self) -> tuple[Expert, ...]:
        """One a task: stay in yellow; two rounds red, green, yellow; yellow or red, then green."""
        return (
            PointExpert(
                "stabilization",
                ((AT_YELLOW,),),
                self.dt,
                CLEARANCE,
                dwell=None,
                pace=(0.5, 0.7),
            ),
            PointExpert("cycle", ((AT_RED, AT_GREEN, AT_YELLOW),), self.dt, CLEARANCE, laps=2),
            PointExpert(
                "disjunction",
                ((AT_YELLOW, AT_GREEN), (AT_RED, AT_GREEN)),
                self.dt,
                CLEARANCE,
                dwell=3,
            ),
        )

    def finite_model(self) -> FiniteModel:
        """A lattice of positions that full and partial actions move between."""
        spacing = self.dt / LATTICE_STEPS
        points = _lattice(spacing)
        clear = rim_distance(points).min(axis=1) > LATTICE_MARGIN
        kept = np.flatnonzero(clear)
        number = np.full(len(points), -1, np.int64)
        number[kept] = np.arange(len(kept))
        side = round(len(points) ** 0.5)
        row, column = np.divmod(kept, side)
        shift = np.arange(-LATTICE_STEPS, LATTICE_STEPS + 1)
        moves = np.stack(np.meshgrid(shift, shift, indexing="ij"), axis=-1).reshape(-1, 2)
        to_row, to_column = row[:, None] + moves[:, 0], column[:, None] + moves[:, 1]
        inside = (to_row >= 0) & (to_row < side) & (to_column >= 0) & (to_column < side)
        target = np.where(inside, to_row * side + to_column, 0)
        reached = np.where(inside, number[target], -1)
        stay = np.arange(len(kept))[:, None]
        if self.random_start:
            free = rim_distance(points[kept], signed=True).min(axis=1) > 0
            initial = np.flatnonzero(free)
        else:
            initial = np.flatnonzero((np.abs(points[kept] - START) < spacing / 2).all(axis=1))
        how = f"dynamic programming on a lattice of {len(kept)} positions {spacing:g} m apart: "
        if self.random_start:
            how += "an estimate, the mean over the lattice's free positions"
        else:
            how += "a lower bound, reached by real actions"
        return FiniteModel(
            observations=points[kept].astype(np.float32),
            successor=np.where(reached >= 0, reached, stay).astype(np.int64),
            initial=initial.astype(np.int64),
            actions=(moves / LATTICE_STEPS).astype(np.float32),
            exact=False,
            how=how,
        )

    def _start(self, copies: npt.NDArray[np.int64]) -> Array:
        start = np.tile(np.array(START, np.float32), (len(copies), 1))
        if self.random_start:
            for row, copy in enumerate(copies):
                start[row] = _free_position(self.generator(int(copy)))
        return start

    def _move(self, state: Array, actions: Array) -> Array:
        if actions.shape != state.shape:
            raise ValueError(f"actions must have shape {state.shape}, not {actions.shape}")
        push = np.clip(actions.astype(np.float32), -1.0, 1.0) * np.float32(self.dt)
        return np.asarray(np.clip(state + push, -BOUND, BOUND))

    def _observe(self, state: Array) -> Array:
        return state.copy()

    def _recover(self, observations: Array) -> Array:
        return observations.astype(np.float32)


class FlatWorldEnv(SingleEnv):
    """One point in FlatWorld; see FlatWorldVectorEnv."""

    def __init__(self, render_mode: str | None = None, **kwargs: Any) -> None:
        super().__init__(FlatWorldVectorEnv(1, render_mode=render_mode, **kwargs))


def rim_distance(
    points: npt.NDArray[np.floating], *, signed: bool = False
) -> npt.NDArray[np.float64]:
    """How far points [n, 2] are from the rim of each of DISCS, [n, 4]; signed: negative inside."""
    centers = np.array([disc.center for disc in DISCS])
    radii = np.array([disc.radius for disc in DISCS])
    gap = np.linalg.norm(points[:, None, :].astype(np.float64) - centers, axis=-1) - radii
    return np.asarray(gap if signed else np.abs(gap), np.float64)


def _lattice(spacing: float) -> npt.NDArray[np.float64]:
    """All points of [-2, 2]² that are whole multiples of `spacing` away from START, [side², 2]."""
    below = int((START[0] + BOUND) / spacing + 1e-9)
    above = int((BOUND - START[0]) / spacing + 1e-9)
    axis = START[0] + spacing * np.arange(-below, above + 1)
    return np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)


def _free_position(generator: np.random.Generator) -> npt.NDArray[np.float32]:
    """A position drawn evenly from what lies outside all discs."""
    while True:
        position = generator.uniform(-BOUND, BOUND, 2).astype(np.float32)
        if rim_distance(position[None], signed=True).min() > 0:
            return position
