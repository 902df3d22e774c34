"""Records: what was run and what came of it, one JSON object a run and seed (measuring.md).

`results/*.jsonl.gz` keeps them in git: sorted, compressed without a time stamp, so that the same
records are the same bytes whoever merged them and in whatever order.
"""

from __future__ import annotations

import errno
import gzip
import json
import os
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate.alone import alone
from tiloilc.writing import write_file

__all__ = [
    "Record",
    "append",
    "dedupe",
    "prepare",
    "read",
    "records_of_run",
    "split_seeds",
    "write",
]

Json: TypeAlias = "bool | int | float | str | list[Json] | dict[str, Json] | None"

SCHEMA_VERSION = 1

POLICIES = ("greedy", "stochastic", "last", "cloning")
"""The entries of an evaluation that hold one value a seed for each metric."""

IDENTITY = (
    "name", "spec_digest", "plan_digest", "algorithm", "preset", "overrides", "seed", "git_commit"
)  # fmt: skip
"""What makes two records the same experiment. The commit is part of it: a change that moves
results keeps its records from before and after."""


@dataclass(frozen=True)
class Record:
    """One run of one seed, as canonical JSON text; equal text is an equal record."""

    text: str

    @classmethod
    def of(cls, fields: Mapping[str, Json]) -> Record:
        """A record of JSON fields; its text has sorted keys and no spaces."""
        return cls(
            json.dumps(
                fields, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False
            )
        )

    @property
    def fields(self) -> dict[str, Json]:
        """The record's fields, as a new dictionary."""
        fields: dict[str, Json] = json.loads(self.text)
        return fields

    @property
    def identity(self) -> str:
        """The experiment it is a record of, as text."""
        fields = self.fields
        return json.dumps([fields.get(key) for key in IDENTITY], sort_keys=True)

    @property
    def interrupted(self) -> bool:
        """Whether the run was cut short."""
        return bool(self.fields.get("interrupted"))

    def _rank(self) -> tuple[bool, int, str]:
        """Of two records of one experiment the greater one is kept."""
        steps = self.fields.get("steps")
        return (not self.interrupted, steps if isinstance(steps, int) else 0, self.text)


def split_seeds(evaluation: Mapping[str, Json], spec_digest: str | None) -> list[Record]:
    """The records of an `eval.json`, one a seed: its lists over seeds become single values.

    Raises ValueError if a list over seeds has another length than `seeds`.
    """
    seeds = evaluation.get("seeds")
    if not isinstance(seeds, list) or not seeds:
        raise ValueError("`seeds` is not a list of seeds")
    shared = {key: value for key, value in evaluation.items() if key not in ("seeds", "curve")}
    shared |= {"schema_version": SCHEMA_VERSION, "spec_digest": spec_digest}
    curve = evaluation.get("curve") or []
    if not isinstance(curve, list):
        raise ValueError("`curve` is not a list")
    records = []
    for place, seed in enumerate(seeds):
        own: dict[str, Json] = {"seed": seed}
        for policy in POLICIES:
            own[policy] = _of_seed(evaluation.get(policy), place, len(seeds), policy)
        own["curve"] = [_of_seed(point, place, len(seeds), "curve") for point in curve]
        records.append(Record.of({**shared, **own}))
    return records


def records_of_run(run: Path) -> list[Record]:
    """The records of a run folder, from its `eval.json` and `plan.json`.

    Raises CompileError RUN701 if either is missing or damaged.
    """
    evaluation = _load(run, "eval.json")
    digests = _load(run, "plan.json").get("digests")
    named = digests if isinstance(digests, dict) else {}
    spec = next((value for key, value in named.items() if key.startswith("spec:")), None)
    try:
        return split_seeds(evaluation, spec if isinstance(spec, str) else None)
    except ValueError as error:
        raise _unreadable(run, f"eval.json: {error}") from None


def dedupe(records: Iterable[Record]) -> list[Record]:
    """One record an experiment, in a stable order.

    A finished run replaces one that was cut short, and a longer one a shorter. Merging is the union
    of records followed by this; the order of the parts does not matter.
    """
    best: dict[str, Record] = {}
    for record in records:
        known = best.get(record.identity)
        if known is None or record._rank() > known._rank():
            best[record.identity] = record
    return sorted(best.values(), key=_order)


def read(*paths: Path) -> list[Record]:
    """All records of files `*.jsonl.gz` (or plain `.jsonl`), merged.

    Raises CompileError RUN701 with the file and line that is no record.
    """
    return dedupe(record for path in paths for record in _lines(path))


def append(path: Path, records: Sequence[Record]) -> int:
    """Merge `records` into the file, which may not exist yet; how many records it then has.

    The file is replaced in one step, and others that append at the same time wait.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with alone(path.parent):
        known = list(_lines(path)) if path.exists() else []
        merged = dedupe([*known, *records])
        write(path, merged)
    return len(merged)


def prepare(path: Path) -> None:
    """Find out before long work what would keep records from being added to the file.

    Makes its folder. Raises CompileError RUN701 for a damaged file, OSError for a place that cannot
    be written to.
    """
    if path.exists():
        read(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))


def write(path: Path, records: Iterable[Record]) -> None:
    """Replace the file by these records: the same records give the same bytes."""
    text = "".join(f"{record.text}\n" for record in records).encode()
    packed = gzip.compress(text, compresslevel=9, mtime=0) if path.suffix == ".gz" else text
    write_file(path, packed, sync=True)


def _of_seed(values: Json, place: int, seeds: int, where: str) -> Json:
    """One seed's part of lists over seeds; what is no list belongs to all."""
    if not isinstance(values, dict):
        return values
    own: dict[str, Json] = {}
    for name, column in values.items():
        if isinstance(column, list):
            if len(column) != seeds:
                raise ValueError(f"`{where}.{name}` has {len(column)} values for {seeds} seeds")
            own[name] = column[place]
        else:
            own[name] = column
    return own


def _lines(path: Path) -> Iterator[Record]:
    try:
        raw = path.read_bytes()
        text = (gzip.decompress(raw) if path.suffix == ".gz" else raw).decode()
    except (OSError, EOFError, UnicodeDecodeError, zlib.error) as error:
        raise _unreadable(path, _reason(error)) from None
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            fields = json.loads(line)
        except json.JSONDecodeError:
            fields = None
        if not isinstance(fields, dict) or not isinstance(fields.get("seed"), int):
            raise _unreadable(path, f"line {number} is no record")
        yield Record.of(fields)


def _load(run: Path, name: str) -> dict[str, Json]:
    try:
        value = json.loads((run / name).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        absent = name == "eval.json" and isinstance(error, FileNotFoundError)
        help = f"evaluate it first: tiloilc eval {run.as_posix()}" if absent else ""
        raise _unreadable(run, f"{name}: {_reason(error)}", help) from None
    if not isinstance(value, dict):
        raise _unreadable(run, f"{name} is no JSON object")
    return value


def _order(record: Record) -> tuple[str, str, int, str]:
    fields = record.fields
    seed = fields.get("seed")
    number = seed if isinstance(seed, int) else 0
    return (str(fields.get("name")), str(fields.get("algorithm")), number, record.text)


def _reason(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    if isinstance(error, json.JSONDecodeError):
        return f"no JSON at line {error.lineno}, column {error.colno}"
    if isinstance(error, OSError):
        return (error.strerror or str(error)).lower()
    return "the file is damaged"


def _unreadable(path: Path, problem: str, help: str = "") -> CompileError:
    return CompileError(Diagnostic.of("RUN701", path=str(path), problem=problem, help=help))
