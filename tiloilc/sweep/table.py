"""What a sweep has come to: one row a task and set of settings, from the records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import mean, stdev

from tiloilc.evaluate import Record
from tiloilc.sweep.experiments import Experiment

COLUMNS = ("task", "settings", "steps", "seeds", "accepting visits", "violations", "optimum")
_TEXT = 2
"""The first columns are text, the others numbers."""


def table(experiments: Sequence[Experiment], records: Sequence[Mapping[int, Record]]) -> str:
    """The table as text: mean ± standard deviation over seeds, of greedy actions.

    An experiment of which seeds are missing says how many it has of them.
    """
    rows = [COLUMNS, *(_row(*pair) for pair in zip(experiments, records, strict=True))]
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    lines = []
    for row in rows:
        cells = [
            cell.ljust(width) if i < _TEXT else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def _row(one: Experiment, records: Mapping[int, Record]) -> tuple[str, ...]:
    fields = [records[seed].fields for seed in sorted(records)]
    greedy = [judged for f in fields if isinstance(judged := f.get("greedy"), dict)]
    visits = [float(str(judged["accepting_visits"])) for judged in greedy]
    violations = [float(str(judged["violation_rate"])) for judged in greedy]
    missing = len(records) < len(one.seeds)
    return (
        one.plan.name,
        one.words,
        f"{one.steps:,}",
        f"{len(records)} of {len(one.seeds)}" if missing else str(len(records)),
        f"{mean(visits):.2f} ± {stdev(visits) if len(visits) > 1 else 0.0:.2f}" if visits else "–",
        f"{mean(violations):.1%}" if violations else "–",
        _optimum(next((f.get("optimum") for f in fields), None)),
    )


def _optimum(optimum: object) -> str:
    if not isinstance(optimum, Mapping):
        return "–"
    return f"{'' if optimum['exact'] else '≥ '}{optimum['accepting_visits']:g}"
