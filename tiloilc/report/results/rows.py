"""Records → rows: the seeds of one task, method, settings and length, and where they are kept.

What makes a row and which records count in it is said in `docs/results/all.md`; the rules are here.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tiloilc.evaluate import Record
from tiloilc.report.results.tasks import TaskFile

__all__ = ["FRESH", "Floats", "Row", "rows_of"]

Floats: TypeAlias = NDArray[np.float64]
Fields: TypeAlias = Mapping[str, object]
Changes: TypeAlias = tuple[tuple[str, str], ...]

FRESH = 200
"""Seeds from here on served no choice of a setting (ADR 17). Where a row has any, they are it."""

FULL = 10
"""Seeds, as the paper has."""

ASIDE = frozenset({"algorithm", "seeds", "first_seed", "checkpoint_every", "device", "compile"})
"""What a record's overrides name beside how an agent learns: it says which run, or where it ran."""


@dataclass(frozen=True)
class Row:
    """Runs that differ in their seeds only, one a seed in their order, as a record's fields each.

    `changes` are the settings that differ from the preset's and `demonstrations` those that differ
    from the task file's, as JSON. `asked` are the steps of the task file, None if there is none.
    """

    task: str
    algorithm: str
    preset: str
    changes: Changes
    demonstrations: Changes
    steps: int
    asked: int | None
    runs: tuple[Fields, ...]

    @property
    def anchor(self) -> str:
        """Its place on the page of all rows; the same for the same task and settings."""
        key = [
            self.task,
            self.algorithm,
            self.preset,
            self.changes,
            self.demonstrations,
            self.steps,
        ]
        return f"r-{hashlib.sha256(json.dumps(key).encode()).hexdigest()[:8]}"

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds in their order."""
        return tuple(_whole(run["seed"]) for run in self.runs)

    @property
    def short(self) -> bool:
        """Whether it took fewer steps than the task file asks for; cloning alone takes none."""
        return self.algorithm != "cloning" and self.asked is not None and self.steps < self.asked

    @property
    def lacks(self) -> str:
        """What it has less than ten seeds and the task file's steps; empty if nothing."""
        count = len(self.runs)
        said = [f"{count} seed{'' if count == 1 else 's'}"] if count < FULL else []
        if self.short:
            said.append(f"{self.steps:,} of {self.asked:,} steps")
        return ", ".join(said)

    @property
    def commits(self) -> tuple[str, ...]:
        """The commits it ran at, short; a mark for those with changes not committed."""
        found = {str(run.get("git_commit") or "unknown") for run in self.runs}
        return tuple(sorted(c[:7] + ("-dirty" if c.endswith("-dirty") else "") for c in found))

    @property
    def named(self) -> str:
        """Its settings in words: what differs from the preset and from the task file."""
        return " ".join(f"{name}={value}" for name, value in (*self.changes, *self.demonstrations))

    @property
    def optimum(self) -> tuple[float, bool] | None:
        """The most accepting visits in an episode, and whether that is exact or a lower bound."""
        for run in sorted(self.runs, key=_when, reverse=True):
            best = run.get("optimum")
            if isinstance(best, Mapping):
                return float(best["accepting_visits"]), bool(best["exact"])
        return None

    def values(self, policy: str, metric: str = "accepting_visits") -> Floats:
        """One number a seed, of those that have one: `policy` is greedy, last, cloning, …"""
        judged = [run.get(policy) for run in self.runs]
        numbers = [one.get(metric) for one in judged if isinstance(one, Mapping)]
        return np.array([n for n in numbers if n is not None], dtype=np.float64)

    def curve(self, metric: str) -> tuple[list[int], Floats]:
        """(steps, values [points, seeds]) at the steps at which every seed was judged."""
        by_seed: list[dict[int, float]] = []
        for run in self.runs:
            points = run.get("curve")
            assert isinstance(points, list)
            found = {p["step"]: p.get(metric) for p in points}
            by_seed.append({step: v for step, v in found.items() if v is not None})
        shared = sorted(set.intersection(*(set(one) for one in by_seed)))
        values = [[one[step] for one in by_seed] for step in shared]
        return shared, np.array(values, dtype=np.float64).reshape(len(shared), len(by_seed))

    def setting(self, name: str) -> str | None:
        """What it changes a setting to, as JSON; None if it leaves it."""
        return dict(self.changes).get(name)

    def without(self, *names: str) -> Changes:
        """Its changes but for some settings."""
        return tuple(pair for pair in self.changes if pair[0] not in names)


def rows_of(records: Iterable[Record], tasks: Mapping[str, TaskFile]) -> list[Row]:
    """All rows of finished runs, in a stable order."""
    groups: dict[tuple[str, str, str, Changes, Changes, int], list[Fields]] = {}
    for record in records:
        fields: Fields = record.fields
        if fields.get("interrupted"):
            continue
        task = str(fields["name"])
        key = (
            task,
            str(fields["algorithm"]),
            str(fields["preset"]),
            settings_of(fields.get("overrides")),
            _demonstrations(fields.get("demonstrations"), tasks.get(task)),
            _whole(fields["steps"]),
        )
        groups.setdefault(key, []).append(fields)
    asked = {name: file.train.steps for name, file in tasks.items()}
    return [Row(*key, asked.get(key[0]), _chosen(groups[key])) for key in sorted(groups)]


def settings_of(overrides: object) -> Changes:
    """Overrides as they name a row: without what is not about learning, values as JSON."""
    given = overrides if isinstance(overrides, Mapping) else {}
    return tuple((k, _shown(v)) for k, v in sorted(given.items()) if k not in ASIDE)


def _shown(value: object) -> str:
    """A value as JSON; a whole number in one way, whether it was written as one or not."""
    whole = isinstance(value, float) and value.is_integer()
    return json.dumps(int(value) if whole and isinstance(value, float) else value, sort_keys=True)


def _demonstrations(given: object, task: TaskFile | None) -> Changes:
    """How a run's demonstrations differ from the task file's; nothing if it does not name them."""
    if not isinstance(given, Mapping) or task is None:
        return ()
    usual = task.demonstrations
    names = sorted(set(given) | set(usual))
    pairs = [(name, _plain(given.get(name)), _plain(usual.get(name))) for name in names]
    return tuple((f"demonstrations.{n}", _shown(is_)) for n, is_, was in pairs if is_ != was)


def _plain(value: object) -> object:
    """A path's last part: from where it was reached does not matter."""
    return PurePosixPath(value).name if isinstance(value, str) else value


def _chosen(runs: Sequence[Fields]) -> tuple[Fields, ...]:
    """One run a seed: fresh seeds if there are any, of the latest commit, then of most seeds."""
    fresh = [run for run in runs if _whole(run["seed"]) >= FRESH]
    runs = fresh or runs
    count: dict[object, int] = {}
    for run in runs:
        count[run.get("git_commit")] = count.get(run.get("git_commit"), 0) + 1

    def rank(run: Fields) -> tuple[int, int, str, str]:
        commit = run.get("git_commit")
        return _when(run), count[commit], str(commit), str(run.get("plan_digest"))

    best: dict[int, Fields] = {}
    for run in sorted(runs, key=rank):
        best[_whole(run["seed"])] = run
    return tuple(best[seed] for seed in sorted(best))


def _when(run: Fields) -> int:
    """When its commit was made; records of old do not say and count as the oldest."""
    time = run.get("git_time")
    return time if isinstance(time, int) else 0


def _whole(value: object) -> int:
    assert isinstance(value, int), f"no whole number: {value!r}"
    return value
