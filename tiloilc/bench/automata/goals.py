"""Automata in the table of goals: states in all, formulas above the best, time of one."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.bench.automata.measure import Row
from tiloilc.bench.measurement import Measurement, Spread


def measurements(rows: Sequence[Row]) -> list[Measurement]:
    """The rows of the formulas from the literature; none without them."""
    if not rows:
        return []
    states = Spread.of([sum(row.edge.states for row in rows)])
    above = Spread.of([sum(row.is_above for row in rows)])
    times = Spread.of([row.edge.ms for row in rows])
    name = f"automata of {len(rows)} formulas"
    return [
        Measurement(f"{name}, marked edges", states, "states", goal=1500),
        Measurement(f"{name}, above the best published size", above, "formulas", goal=0),
        Measurement(f"{name}, one translation", times, "ms", goal=5),
    ]
