"""YAML as a tree in which every node knows its place."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from tiloilc.diag import SourceText, Span


@dataclass(frozen=True, slots=True)
class Scalar:
    """A single value. `plain` is unquoted text, whose type its look decides."""

    text: SourceText
    span: Span
    plain: bool
    size: int = 1


@dataclass(frozen=True, slots=True)
class Entry:
    """A key and its value."""

    key: Scalar
    value: Node


@dataclass(frozen=True, slots=True)
class MappingNode:
    """Keys and values in the written order; `size` counts the nodes with aliases expanded."""

    entries: Mapping[str, Entry]
    span: Span
    size: int


@dataclass(frozen=True, slots=True)
class SequenceNode:
    """Items in the written order."""

    items: tuple[Node, ...]
    span: Span
    size: int


Node = Scalar | MappingNode | SequenceNode


@dataclass(frozen=True, slots=True)
class Source:
    """A file's text and where its lines begin; only a line feed ends a line."""

    text: str
    file: str
    _starts: list[int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        starts = [0, *(match.end() for match in re.finditer("\n", self.text))]
        object.__setattr__(self, "_starts", starts)

    def place(self, index: int) -> tuple[int, int]:
        """1-based line and column of `text[index]`; the end of the text has a place too."""
        line = bisect_right(self._starts, index)
        return line, index - self._starts[line - 1] + 1

    def span(self, start: int, end: int) -> Span:
        """The stretch `text[start:end]`; an empty one covers one character."""
        line, column = self.place(start)
        if end <= start:
            return Span.at(self.file, line, column)
        end_line, end_column = self.place(end - 1)
        return Span(self.file, line, column, end_line, end_column + 1)

    def line_end(self, index: int) -> int:
        """Where the line of `text[index]` ends, without its line break."""
        end = self.text.find("\n", index)
        end = len(self.text) if end < 0 else end
        return end - 1 if end > index and self.text[end - 1] == "\r" else end


def kind_of(node: Node) -> str:
    """What a node is, for people."""
    match node:
        case MappingNode():
            return "a mapping of keys to values"
        case SequenceNode():
            return "a list"
        case Scalar() if is_empty(node):
            return "empty"
        case Scalar():
            return f"`{shorten(node.text.value)}`"


def shorten(text: str, limit: int = 40) -> str:
    """`text` on one line of at most `limit` characters."""
    line = " ".join(text.split())
    return line if len(line) <= limit else line[: limit - 1] + "…"


_NULL = re.compile(r"~|null|Null|NULL|")
_TRUE = re.compile(r"true|True|TRUE")
_FALSE = re.compile(r"false|False|FALSE")
_WHOLE = re.compile(r"[-+]?[0-9]+")
_OCTAL = re.compile(r"0o[0-7]+")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"[-+]?\.(inf|Inf|INF)")
_UNDEFINED = re.compile(r"\.(nan|NaN|NAN)")

MAX_DIGITS = 1_000
"""Longer numbers stay text: Python refuses to read them, and nobody means them."""


def is_empty(node: Scalar) -> bool:
    """Nothing at all, or one of YAML's words for it."""
    return node.plain and _NULL.fullmatch(node.text.value) is not None


def scalar_value(node: Scalar) -> str | int | float | bool | None:
    """The value by the core schema of YAML 1.2 (section 10.3.2): `yes` and `1_000` are text."""
    text = node.text.value
    if not node.plain:
        return text
    if _NULL.fullmatch(text):
        return None
    if _TRUE.fullmatch(text) or _FALSE.fullmatch(text):
        return text.lower() == "true"
    if len(text) > MAX_DIGITS:
        return text
    for pattern, base in ((_WHOLE, 10), (_OCTAL, 8), (_HEX, 16)):
        if pattern.fullmatch(text):
            return int(text if base == 10 else text[2:], base)
    if _INFINITE.fullmatch(text) or _UNDEFINED.fullmatch(text):
        return float(text.replace(".", ""))
    return float(text) if _FLOAT.fullmatch(text) else text


Path = Sequence[str | int]


def find(root: Node, path: Path) -> Node | None:
    """The node at `path`, or None."""
    node: Node | None = root
    for part in path:
        node = child(node, part) if node is not None else None
    return node


def child(node: Node, part: str | int) -> Node | None:
    """The value under one key or index, or None."""
    if isinstance(node, MappingNode):
        entry = node.entries.get(str(part))
        return entry.value if entry else None
    if isinstance(node, SequenceNode) and isinstance(part, int) and 0 <= part < len(node.items):
        return node.items[part]
    return None


def entry_at(root: Node, path: Path) -> Entry | None:
    """The key and value at `path`, or None where there is no such key."""
    parent = find(root, path[:-1]) if path else None
    return parent.entries.get(str(path[-1])) if isinstance(parent, MappingNode) else None


def entries_of(node: Node | None) -> Iterator[tuple[str, Entry]]:
    """The entries of a mapping; none of anything else."""
    if isinstance(node, MappingNode):
        yield from node.entries.items()
