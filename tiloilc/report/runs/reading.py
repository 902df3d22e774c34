"""Checked access to JSON, event logs, rewards: the contract promises their shape, files do not."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from tiloilc.evaluate.records import Json

__all__ = [
    "Events",
    "Floats",
    "Object",
    "Rewards",
    "Unfit",
    "floats",
    "integer",
    "mapping",
    "parse",
    "read_events",
    "read_film",
    "read_rewards",
    "table",
    "words",
]

Floats: TypeAlias = npt.NDArray[np.float64]
Object: TypeAlias = Mapping[str, Json]


MOST_FILM = 4_000_000
"""Bytes of a film in a page, which stays one file that a phone opens."""


class Unfit(ValueError):
    """A value is not what the format says; the message says which and how."""


def parse(text: str, where: str) -> dict[str, Json]:
    """A JSON object."""
    try:
        value: Json = json.loads(text)
    except json.JSONDecodeError as error:
        raise Unfit(f"{where} is no JSON: line {error.lineno}, column {error.colno}") from None
    return mapping(value, where)


def mapping(value: Json, where: str) -> dict[str, Json]:
    """A JSON object; null counts as an empty one."""
    if value is None:
        return {}
    if not isinstance(value, dict):
        raise Unfit(f"{where} is no object")
    return value


def integer(value: Json, where: str) -> int:
    """A whole number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value != int(value):
        raise Unfit(f"{where} is no whole number")
    return int(value)


def words(value: Json) -> dict[str, str]:
    """An object's values as text, in its order; nothing if it is no object."""
    if not isinstance(value, Mapping):
        return {}
    return {key: item if isinstance(item, str) else json.dumps(item) for key, item in value.items()}


def floats(value: Json, where: str, count: int) -> Floats:
    """A list of `count` numbers, null as nan."""
    if not isinstance(value, list) or len(value) != count:
        raise Unfit(f"{where} is no list of {count} numbers")
    return np.array([_number(item, where) for item in value], dtype=np.float64)


def _number(item: Json, where: str) -> float:
    """A number; null is nan."""
    if item is None:
        return float("nan")
    if isinstance(item, bool) or not isinstance(item, int | float):
        raise Unfit(f"{where} holds something else than numbers")
    return float(item)


def table(value: Json, where: str, rows: int) -> Floats:
    """`rows` lists of equally many numbers, as an array [rows, …]."""
    if not isinstance(value, list) or len(value) != rows or not rows:
        raise Unfit(f"{where} is no list of {rows} lists")
    first = value[0]
    width = len(first) if isinstance(first, list) else 0
    lists: Sequence[Floats] = [floats(row, where, width) for row in value]
    return np.stack(lists)


@dataclass
class Events:
    """What the lines of an event log say, gathered while reading."""

    start: Object = field(default_factory=dict)
    train: list[Object] = field(default_factory=list)
    eval: list[Object] = field(default_factory=list)
    ended: bool = False
    last: int = 0


def read_events(log: Path, notes: list[str]) -> Events:
    """The events of a log; what is missing or cut off goes to `notes`. Raises Unfit if damaged."""
    events = Events()
    if not log.is_file():
        notes.append("events.jsonl is missing: nothing is known of how training went.")
        return events
    for line in _lines(log, notes):
        kind = line.get("type")
        events.last = max(events.last, integer(line.get("step"), "`step` of an event"))
        if kind == "start":
            events.start = line
        elif kind == "train":
            events.train.append(line)
        elif kind == "eval":
            events.eval.append(line)
        elif kind == "end":
            events.ended = True
    return events


def _lines(log: Path, notes: list[str]) -> Iterator[dict[str, Json]]:
    """The events; a last line without an end was being written when the run was killed."""
    try:
        lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
    except UnicodeDecodeError:
        raise Unfit("events.jsonl is damaged") from None
    for number, line in enumerate(lines, start=1):
        try:
            yield parse(line, f"events.jsonl, line {number},")
        except Unfit:
            if number == len(lines) and not line.endswith("\n"):
                notes.append("The last event was cut off while it was being written.")
                return
            raise


@dataclass(frozen=True)
class Rewards:
    """The mean over seeds of Eq. 8 at [y, x], for each automaton state: `mean` [state, h, w]."""

    x: Floats
    y: Floats
    mean: Floats


def read_rewards(file: Path) -> Rewards | None:
    """What evaluation left; None if it left nothing. Raises Unfit for a damaged file."""
    if not file.is_file():
        return None
    try:
        with np.load(file, allow_pickle=False) as arrays:
            x, y, every = (np.asarray(arrays[n], np.float64) for n in ("x", "y", "rewards"))
    except Exception:  # zipfile, zlib and numpy each raise their own for a damaged archive
        raise Unfit(f"{file.name} is damaged") from None
    if every.ndim != 4 or every.shape[2:] != (*y.shape, *x.shape) or not np.isfinite(every).all():
        raise Unfit(f"{file.name}: its arrays do not fit each other")
    return Rewards(x, y, every.mean(axis=0))


def read_film(file: Path) -> bytes:
    """The GIF that `eval --video` wrote; empty if there is none, or too large a one for a page."""
    return file.read_bytes() if file.is_file() and file.stat().st_size <= MOST_FILM else b""
