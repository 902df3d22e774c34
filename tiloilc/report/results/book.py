"""All rows, and how a page finds the ones it is about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tiloilc.evaluate import Record, read
from tiloilc.report.results.methods import METHODS
from tiloilc.report.results.rows import Changes, Row, rows_of, settings_of
from tiloilc.report.results.tasks import TITLES, TaskFile, read_tasks

__all__ = ["Book", "Family", "open_book"]


@dataclass(frozen=True)
class Family:
    """Rows of one task that differ in some settings only, by what they change of these."""

    task: str
    members: Mapping[Changes, Row]

    def get(self, **changes: str) -> Row | None:
        """The row with these values, as JSON, and no other of the family's settings changed."""
        return self.members.get(tuple(sorted(changes.items())))

    def named(self, *settings: str) -> str:
        """What its rows have in common, in words; `settings` are what they differ in."""
        row = next(iter(self.members.values()), None)
        if row is None:
            return ""
        shared = [f"{k}={v}" for k, v in (*row.without(*settings), *row.demonstrations)]
        return " ".join([row.preset, *shared])


@dataclass(frozen=True)
class Book:
    """The rows of all records and the task files; and those of what was verified."""

    rows: tuple[Row, ...]
    files: Mapping[str, TaskFile]
    verified: tuple[Row, ...] = ()

    @classmethod
    def of(
        cls,
        records: Sequence[Record],
        files: Mapping[str, TaskFile],
        verified: Sequence[Record] = (),
    ) -> Book:
        """The rows of `records`, and of those that `verify` made of the same runs."""
        return cls(tuple(rows_of(records, files)), files, tuple(rows_of(verified, files)))

    @property
    def tasks(self) -> list[str]:
        """Every task with a file or a record: the paper's in its order, then others."""
        names = {row.task for row in self.rows} | set(self.files)
        order = {name: place for place, name in enumerate(TITLES)}
        return sorted(names, key=lambda name: (order.get(name, len(order)), name))

    @property
    def algorithms(self) -> list[str]:
        """The methods of the paper in their order, then what else has records."""
        more = sorted({row.algorithm for row in self.rows} - set(METHODS))
        return [*METHODS, *more]

    def usual(self, task: str, algorithm: str, preset: str = "default") -> Row | None:
        """The row with the task file's own settings and demonstrations, the longest there is.

        Of the preset `paper`, whose settings a task file can replace, the one that keeps fewest of
        the task file's.
        """
        own = self.own(task, algorithm, preset)
        found = [
            row
            for row in self.of_task(task, algorithm)
            if row.preset == preset
            and not row.demonstrations
            and (row.changes == own or (preset == "paper" and set(row.changes) <= set(own)))
        ]
        return max(found, key=lambda r: (-len(r.changes), r.steps, len(r.runs)), default=None)

    def own(self, task: str, algorithm: str = "tiloil", preset: str = "default") -> Changes:
        """What the task file changes of a preset; nothing if there is no task file."""
        file = self.files.get(task)
        return () if file is None else settings_of(file.defaults(preset, algorithm))

    def of_task(self, task: str, algorithm: str | None = None) -> list[Row]:
        """The rows of a task, or of one method on it."""
        return [r for r in self.rows if r.task == task and algorithm in (None, r.algorithm)]

    def families(self, task: str, *settings: str, apart: Sequence[str] = ()) -> list[Family]:
        """TiLoIL's rows in groups that differ in `settings` only, those of two rows or more.

        Rows that change one of the settings `apart` stay away. The group with the task file's own
        other settings comes first, and one that was run again for longer is left out. Where there
        is no group: the usual row alone, or nothing.
        """
        groups: dict[tuple[Changes, str, Changes, int], dict[Changes, Row]] = {}
        for row in self.of_task(task, "tiloil"):
            if any(row.setting(name) is not None for name in apart):
                continue
            key = (row.without(*settings), row.preset, row.demonstrations, row.steps)
            varied = tuple(pair for pair in row.changes if pair[0] in settings)
            groups.setdefault(key, {})[varied] = row
        own = tuple(pair for pair in self.own(task) if pair[0] not in settings)
        order = sorted(groups, key=lambda key: (key[0] != own, -key[3], key))
        last = [
            key
            for i, key in enumerate(order)
            if not any(
                key[:3] == k[:3] and groups[key].keys() <= groups[k].keys() for k in order[:i]
            )
        ]
        found = [Family(task, groups[key]) for key in last if len(groups[key]) > 1]
        lone = self.usual(task, "tiloil")
        if found or lone is None:
            return found or [Family(task, {})]
        return [Family(task, {tuple(p for p in lone.changes if p[0] in settings): lone})]

    def verification(self, task: str, algorithm: str) -> Row | None:
        """What was verified of the usual row's agents; None if nothing."""
        row = self.usual(task, algorithm)
        anchor = None if row is None else row.anchor
        return next((one for one in self.verified if one.anchor == anchor), None)

    def optimum(self, task: str) -> tuple[float, bool] | None:
        """The most accepting visits in an episode, and whether that is exact: the highest known."""
        known = [row.optimum for row in self.of_task(task)]
        return max((one for one in known if one is not None), default=None)


def open_book(results: Path, specs: Path) -> Book:
    """The records `results/*.jsonl.gz` and `results/verified/` beside the files of `specs`."""
    found = read(*sorted(results.glob("*.jsonl.gz")))
    verified = read(*sorted(results.glob("verified/*.jsonl.gz")))
    return Book.of(found, read_tasks(specs), verified)
