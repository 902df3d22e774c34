"""What pages say of rows in numbers: returns, efficiency, what one change is worth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tiloilc.evaluate import (
    Interval,
    area_under_curve,
    band,
    difference,
    generator,
    steps_to_threshold,
    stratified_bootstrap,
)
from tiloilc.evaluate.statistics import RESAMPLES
from tiloilc.report.frame import short
from tiloilc.report.results.drawing import Line
from tiloilc.report.results.methods import Ink
from tiloilc.report.results.rows import Floats, Row

__all__ = ["ENOUGH", "gap", "height", "line", "mean_of_tasks", "most_return", "reached"]

ENOUGH = 0.9
"""The share of a goal whose first reaching is told (measuring: sample efficiency)."""

GAMMA = 0.99
"""What the eventual returns of records are discounted by."""


def gap(one: Row | None, other: Row | None) -> str:
    """How many visits more the other row has, with its 95 % interval; a dash without both."""
    if one is None or other is None:
        return "–"
    value, interval = difference(one.values("greedy"), other.values("greedy"), generator())
    return f"{value:+.2f} [{interval.low:+.2f}, {interval.high:+.2f}]"


def reached(row: Row, goal: float | None) -> str:
    """After how many steps the mean over seeds first makes 90 % of a goal, in validation."""
    steps, values = row.curve("accepting_visits")
    if goal is None or goal <= 0 or not steps:
        return "–"
    found = steps_to_threshold(steps, values, ENOUGH * goal)
    return "never" if found is None else short(found)


def mean_of_tasks(
    strata: Sequence[Floats], *, resamples: int = RESAMPLES
) -> tuple[float, Interval]:
    """The mean over tasks of their means over seeds, and its 95 % stratified bootstrap interval.

    Tasks weigh the same, whatever their number of seeds is.
    """
    weights = np.concatenate([np.full(v.size, 1 / (v.size * len(strata))) for v in strata])

    def mean(drawn: Floats) -> Floats:
        return np.asarray(drawn @ weights)

    interval = stratified_bootstrap(strata, mean, generator(), resamples=resamples)
    return float(np.concatenate(strata) @ weights), interval


def height(row: Row) -> Floats:
    """Each seed's mean height of its curve of visits over training; empty if it has no curve."""
    steps, values = row.curve("accepting_visits")
    return area_under_curve(steps, values) if steps else np.zeros(0)


def line(row: Row, label: str, ink: Ink) -> Line | None:
    """Its curve of eventual returns; None if it was judged fewer than two times."""
    steps, values = row.curve("eventual_return")
    return Line(label, ink, steps, band(values, generator())) if len(steps) > 1 else None


def most_return(visits: float) -> float:
    """The eventual return of so many visits (Eq. 17 and 18); the mean of counts bounds the mean."""
    return float((1 - GAMMA**visits) / (1 - GAMMA))
