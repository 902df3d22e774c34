"""What pages say of rows in numbers: returns, efficiency, what one change is worth."""

from __future__ import annotations

import numpy as np

from tiloilc.evaluate import (
    Interval,
    area_under_curve,
    band,
    generator,
    steps_to_threshold,
    stratified_bootstrap,
)
from tiloilc.report.frame import short
from tiloilc.report.results.drawing import Line
from tiloilc.report.results.methods import Ink
from tiloilc.report.results.rows import Floats, Row

__all__ = ["ENOUGH", "difference", "height", "line", "most_return", "reached", "won"]

ENOUGH = 0.9
"""The share of a goal whose first reaching is told (measuring: sample efficiency)."""


def difference(before: Floats, after: Floats) -> tuple[float, Interval]:
    """How much higher the mean of `after` is than that of `before`, with its 95 % interval."""
    n = len(before)

    def gap(drawn: Floats) -> Floats:
        return np.asarray(drawn[..., n:].mean(-1) - drawn[..., :n].mean(-1))

    interval = stratified_bootstrap([before, after], gap, generator())
    return float(after.mean() - before.mean()), interval


def won(row: Row, other: Row) -> bool:
    """Whether the mean of `row` is higher by more than chance among seeds."""
    return difference(other.values("greedy"), row.values("greedy"))[1].low > 0


def reached(row: Row, goal: float | None) -> str:
    """After how many steps the mean over seeds first makes 90 % of a goal, in validation."""
    steps, values = row.curve("accepting_visits")
    if goal is None or goal <= 0 or not steps:
        return "–"
    found = steps_to_threshold(steps, values, ENOUGH * goal)
    return "never" if found is None else short(found)


def height(row: Row) -> Floats:
    """Each seed's mean height of its curve of visits over training; empty if it has no curve."""
    steps, values = row.curve("accepting_visits")
    return area_under_curve(steps, values) if steps else np.zeros(0)


def line(row: Row, label: str, ink: Ink, metric: str = "eventual_return") -> Line | None:
    """Its learning curve; None if it was judged fewer than two times."""
    steps, values = row.curve(metric)
    return Line(label, ink, steps, band(values, generator())) if len(steps) > 1 else None


def most_return(visits: float, gamma: float = 0.99) -> float:
    """The eventual return of so many visits (Eq. 17 and 18); the mean of counts bounds the mean."""
    return float((1 - gamma**visits) / (1 - gamma))
