"""The table of recorded runs: `python -m tiloilc.report.results RESULTS PAGE` writes it."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tiloilc.evaluate import Record, generator, read, stratified_bootstrap, summarise

HEAD = """\
# Results

One row for each task and setting, over seeds, from the records in `results/`; written by
`make results`, not by hand. *Visits* are accepting visits an episode with greedy actions, of each
seed's best policy by validation episodes; mean ± standard deviation, then the interquartile mean
with its 95 % bootstrap interval. *At the end* is the last policy, *cloning* the one before
reinforcement learning began. *Violations* are episodes that enter a sink. Demonstrations are
state-only unless a row says otherwise. An optimum with ≥ is a lower bound, reached by real actions.

"""

PAIRS = """
## One thing changed

Rows above of one task that differ in one setting only, and by how much the mean of their visits
differs, with its 95 % bootstrap interval: what keeps clear of 0 is more than chance among seeds.

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

PAIR_COLUMNS = ("task", "settings", "changed", "visits before", "visits after", "difference [95 %]")


def results_page(records: Iterable[Record]) -> str:
    """The page as Markdown; the same records give the same text."""
    groups: dict[tuple[str, str], list[Mapping[str, object]]] = {}
    for record in records:
        fields = record.fields
        groups.setdefault((str(fields["name"]), _settings(fields)), []).append(fields)
    page = HEAD + _table(COLUMNS, [_row(*key, groups[key]) for key in sorted(groups)])
    pairs = [_pair(groups[a], groups[b]) for a in sorted(groups) for b in sorted(groups)]
    rows = [row for row in pairs if row]
    return page + (PAIRS + _table(PAIR_COLUMNS, rows) if rows else "")


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _pair(
    group: Sequence[Mapping[str, object]], other: Sequence[Mapping[str, object]]
) -> list[str]:
    """What one more setting than `group` has made of `other`; empty if it is not just one."""
    name, had, has = group[0]["name"], _overrides(group[0]), _overrides(other[0])
    alike = all(group[0][k] == other[0][k] for k in ("name", "algorithm", "preset", "steps"))
    more = has.keys() - had.keys()
    if not alike or len(more) != 1 or {k: v for k, v in has.items() if k in had} != had:
        return []
    before, after = (_values(g, "greedy", "accepting_visits") for g in (group, other))
    n = len(before)

    def difference(drawn: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(drawn[..., n:].mean(-1) - drawn[..., :n].mean(-1))

    interval = stratified_bootstrap([before, after], difference, generator())
    return [
        f"`{name}`",
        _words(group[0]),
        _named({k: has[k] for k in more}),
        _spread(before),
        _spread(after),
        f"{after.mean() - before.mean():+.2f} [{interval.low:+.2f}, {interval.high:+.2f}]",
    ]


def _settings(fields: Mapping[str, object]) -> str:
    """What a run was made with: algorithm, preset, what differs from it, steps."""
    return f"{_words(fields)}, {fields['steps']} steps"


def _words(fields: Mapping[str, object]) -> str:
    return f"{fields['algorithm']} {fields['preset']} {_named(_overrides(fields))}".strip()


def _named(overrides: Mapping[str, object]) -> str:
    return " ".join(f"{name}={json.dumps(value)}" for name, value in sorted(overrides.items()))


def _overrides(fields: Mapping[str, object]) -> dict[str, object]:
    overrides = fields.get("overrides")
    assert isinstance(overrides, Mapping)
    return {k: v for k, v in overrides.items() if k not in ("seeds", "first_seed")}


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
