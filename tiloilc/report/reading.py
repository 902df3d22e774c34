"""Checked access to JSON whose shape is promised by the contract but not by the file system."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from tiloilc.evaluate.records import Json

__all__ = ["Floats", "Unfit", "column", "floats", "integer", "mapping", "parse", "table", "words"]

Floats: TypeAlias = npt.NDArray[np.float64]


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
    return np.array([column(item, where) for item in value], dtype=np.float64)


def column(item: Json, where: str) -> float:
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
