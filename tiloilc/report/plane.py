"""The plane of two observed numbers as a map: for environments that publish none."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tiloilc.label import compile_predicates
from tiloilc.plan import Plan, importable
from tiloilc.report.maps import Map, Shape

COLUMNS, ROWS = 120, 90
"""Places at which propositions are asked."""

COLORS = ("#5c8fd6", "#e0b04c", "#4caf6d", "#d9695f", "#9b7fc4", "#4fa7b5")

MARGIN = 0.08
"""Of the way that observations span, on each side."""


def plane_of(plan: Plan, root: Path, observations: npt.NDArray[np.float32]) -> Map | None:
    """A map of the plane that observations [n, 2] lie in, with the propositions of `plan` as zones.

    Both axes are as long, whatever their units. None where more is observed than two numbers, or
    nothing spans a plane, or a proposition cannot be asked.
    """
    seen = observations[np.isfinite(observations).all(axis=-1)]
    if seen.ndim != 2 or seen.shape[1] != 2 or len(seen) < 2 or not np.ptp(seen, axis=0).all():
        return None
    span = np.ptp(seen, axis=0).astype(np.float64)
    low, high = seen.min(axis=0) - MARGIN * span, seen.max(axis=0) + MARGIN * span
    x = low[0] + (np.arange(COLUMNS) + 0.5) / COLUMNS * (high[0] - low[0])
    y = low[1] + (np.arange(ROWS) + 0.5) / ROWS * (high[1] - low[1])
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2).astype(np.float32)
    python = {p.name: (root / p.python).as_posix() for p in plan.predicates if p.python}
    texts = {p.name: p.text for p in plan.predicates}
    try:
        with importable(root):
            letters = compile_predicates(texts, plan.fields, python)(places)
    except Exception:  # a predicate may be anyone's code
        return None
    stretch = 1 / (high - low)
    corner = (float(low[0] * stretch[0]), float(low[1] * stretch[1]))
    zones = tuple(
        shape
        for i, predicate in enumerate(plan.predicates)
        for shape in _zone(
            predicate.name,
            COLORS[i % len(COLORS)],
            (letters.reshape(ROWS, COLUMNS) >> i & 1).astype(np.bool_),
            corner,
        )
    )
    bounds = (corner[0], corner[1], corner[0] + 1.0, corner[1] + 1.0)
    return Map(
        bounds,
        zones,
        (0, 1),
        (float(stretch[0]), float(stretch[1])),
        (_axis(plan, 0), _axis(plan, 1)),
    )


def _axis(plan: Plan, component: int) -> str:
    """What a component of the observation is called."""
    for name, (start, stop) in plan.fields.items():
        if start <= component < stop:
            return name if stop == start + 1 else f"{name}[{component - start}]"
    return ""


def _zone(
    name: str, color: str, holds: npt.NDArray[np.bool_], corner: tuple[float, float]
) -> Iterator[Shape]:
    """Where a proposition holds, as rectangles; the largest has its name."""
    found = sorted(_rectangles(holds), key=lambda r: -(r[2] - r[0]) * (r[3] - r[1]))
    for i, (left, bottom, right, top) in enumerate(found):
        low = (corner[0] + left / COLUMNS, corner[1] + bottom / ROWS)
        high = (corner[0] + right / COLUMNS, corner[1] + top / ROWS)
        yield Shape("" if i else name, color, low, high, edge=len(found) == 1)


def _rectangles(holds: npt.NDArray[np.bool_]) -> Iterator[tuple[int, int, int, int]]:
    """Rectangles of cells [left, right) × [bottom, top) that cover just the cells that hold."""
    open_: dict[tuple[int, int], int] = {}
    for row in range(len(holds) + 1):
        runs = set(_runs(holds[row])) if row < len(holds) else set()
        for run in [run for run in open_ if run not in runs]:
            yield run[0], open_.pop(run), run[1], row
        for run in sorted(runs):
            open_.setdefault(run, row)


def _runs(row: npt.NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """The stretches [start, stop) of a row that hold."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(np.int8)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
