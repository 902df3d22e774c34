"""The table of recorded runs: `python -m tiloilc.report.results RESULTS PAGE` writes it."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tiloilc.evaluate import Record, generator, read, summarise

HEAD = """\
# Results

One row for each task and setting, over seeds, from the records in `results/`; written by
`make results`, not by hand. *Visits* are accepting visits an episode with greedy actions, of each
seed's best policy by validation episodes; mean ± standard deviation, then the interquartile mean
with its 95 % bootstrap interval. *At the end* is the last policy, *cloning* the one before
reinforcement learning began. *Violations* are episodes that enter a sink. Demonstrations are
state-only unless a row says otherwise. An optimum with ≥ is a lower bound, reached by real actions.

"""

COLUMNS = (
    "task",
    "settings",
    "seeds",
    "steps",
    "visits",
    "IQM [95 %]",
    "violations",
    "at the end",
    "cloning",
    "optimum",
)


def results_page(records: Iterable[Record]) -> str:
    """The page as Markdown; the same records give the same text."""
    groups: dict[tuple[str, str], list[Mapping[str, object]]] = {}
    for record in records:
        fields = record.fields
        groups.setdefault((str(fields["name"]), _settings(fields)), []).append(fields)
    lines = [" | ".join(COLUMNS), " | ".join("---" for _ in COLUMNS)]
    lines += [" | ".join(_row(*key, groups[key])) for key in sorted(groups)]
    return HEAD + "".join(f"| {line} |\n" for line in lines)


def _settings(fields: Mapping[str, object]) -> str:
    """What a run was made with: algorithm, preset, what differs from it, steps."""
    overrides = fields.get("overrides")
    assert isinstance(overrides, Mapping)
    words = [str(fields["algorithm"]), str(fields["preset"])]
    words += [
        f"{name}={json.dumps(value)}"
        for name, value in sorted(overrides.items())
        if name not in ("seeds", "first_seed")
    ]
    return f"{' '.join(words)}, {fields['steps']} steps"


def _row(name: str, settings: str, group: Sequence[Mapping[str, object]]) -> list[str]:
    visits = _values(group, "greedy", "accepting_visits")
    summary = summarise(visits, generator())
    assert summary is not None
    steps = group[0]["steps"]
    assert isinstance(steps, int)
    inner, interval = summary.iqm, summary.iqm_interval
    return [
        f"`{name}`",
        settings.rpartition(",")[0],
        str(len(group)),
        f"{steps:,}",
        _spread(visits),
        f"{inner:.2f} [{interval.low:.2f}, {interval.high:.2f}]",
        f"{_values(group, 'greedy', 'violation_rate').mean():.1%}",
        _spread(_values(group, "last", "accepting_visits")),
        _spread(_values(group, "cloning", "accepting_visits")),
        _optimum(group[0].get("optimum")),
    ]


def _values(group: Sequence[Mapping[str, object]], policy: str, metric: str) -> NDArray[np.float64]:
    judged = [fields.get(policy) for fields in group]
    numbers = [j[metric] for j in judged if isinstance(j, Mapping)]
    return np.array([n for n in numbers if n is not None], dtype=np.float64)


def _spread(values: NDArray[np.float64]) -> str:
    if not len(values):
        return "–"
    spread = values.std(ddof=1) if len(values) > 1 else 0.0
    return f"{values.mean():.2f} ± {spread:.2f}"


def _optimum(optimum: object) -> str:
    if not isinstance(optimum, Mapping):
        return "–"
    return f"{'' if optimum['exact'] else '≥ '}{optimum['accepting_visits']:g}"


def write_results(folder: Path, page: Path) -> None:
    """Write the page of all records in `folder`."""
    page.write_text(results_page(read(*sorted(folder.glob("*.jsonl.gz")))), encoding="utf-8")


if __name__ == "__main__":
    write_results(Path(sys.argv[1]), Path(sys.argv[2]))
