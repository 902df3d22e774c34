"""Where each character of a YAML scalar's value stands in the file.

A scalar's value differs from its text in the file by quotes, escapes, indentation and folded line
breaks, but it has the same characters that are not white space, in the same order. So those are
paired one by one, which makes their places exact in every style, and white space in between is
fitted: what follows the last line break is aligned to the right, where the text goes on.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

WHITE = " \t\n\r"

_DOUBLE = re.compile(
    r"\\(?:x(?P<x>..)|u(?P<u>.{4})|U(?P<U>.{8})|\r?\n[ \t]*|(?P<c>.))|.", re.DOTALL
)
_SINGLE = re.compile(r"''|.", re.DOTALL)
_ESCAPED_WHITE = {"n": "\n", "t": "\t", " ": " ", "\t": "\t", "r": "\r"}

Unit = tuple[int, int, str]
"""A stretch of the file that stands for one character: start, end, and the character."""


def places_of(value: str, raw: str, style: str | None, offset: int) -> list[int]:
    """Indices into the file of each character of `value`, and one more for its end.

    `raw` is the scalar as written, quotes or block header included, and begins at `offset`.
    `style` is YAML's indicator: one of ' " | > or None for plain text.
    """
    units = list(_units(raw, style))
    solid = iter(u for u in units if u[2] not in WHITE)
    runs = _white_runs(units)
    begin = offset + (1 if style in ("'", '"') else 0)
    starts: list[int] = []
    end, solid_end, count = begin, begin, 0
    for white, group in groupby(value, key=lambda c: c in WHITE):
        characters = "".join(group)
        if white:
            run = runs.get(count, ())
            fitted = _fit(characters, run) if run else [end - offset] * len(characters)
            starts.extend(offset + i for i in fitted)
            end = starts[-1] + 1
        else:
            for _ in characters:
                start, stop, _c = next(solid, (end - offset, end - offset, ""))
                starts.append(offset + start)
                end = solid_end = offset + stop
            count += len(characters)
    return [*starts, solid_end if style in ("|", ">") else end]


def _units(raw: str, style: str | None) -> Iterator[Unit]:
    if style == '"':
        for match in _DOUBLE.finditer(raw, 1, max(1, len(raw) - 1)):
            character = _unescaped(match)
            if character:
                yield match.start(), match.end(), character
    elif style == "'":
        for match in _SINGLE.finditer(raw, 1, max(1, len(raw) - 1)):
            yield match.start(), match.end(), match.group()[0]
    else:
        first = raw.find("\n") + 1 if style in ("|", ">") else 0
        for index in range(first, len(raw)):
            yield index, index + 1, raw[index]


def _unescaped(match: re.Match[str]) -> str:
    """The character that a piece of double-quoted text stands for; none for an escaped break.

    Only whether it is white space matters here, so other escapes stand for themselves.
    """
    if not match.group().startswith("\\"):
        return match.group()
    for name in "xuU":
        if match[name] is not None:
            return chr(int(match[name], 16))
    return _ESCAPED_WHITE.get(match["c"], match["c"]) if match["c"] else ""


def _white_runs(units: Sequence[Unit]) -> dict[int, list[Unit]]:
    """White space of the file by how many solid characters stand before it."""
    runs: dict[int, list[Unit]] = {}
    count = 0
    for unit in units:
        if unit[2] in WHITE:
            runs.setdefault(count, []).append(unit)
        else:
            count += 1
    return runs


def _fit(white: str, run: Sequence[Unit]) -> list[int]:
    """Places for a stretch of white space in the value, given the one in the file."""
    if len(white) == len(run):
        return [start for start, _, _ in run]
    head, tail = white[: white.rfind("\n") + 1], white[white.rfind("\n") + 1 :]
    left = [run[min(i, len(run) - 1)][0] for i in range(len(head))]
    right = [run[max(0, len(run) - len(tail) + i)][0] for i in range(len(tail))]
    return left + right
