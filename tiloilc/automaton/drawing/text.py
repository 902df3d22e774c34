"""Text in pictures: how wide it is, where it breaks, and what of a state's name is worth a line.

Formulas are set in a monospaced font, whose characters are equally wide on every machine: the
picture is laid out the same whatever fonts are installed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from tiloilc.automaton.draft import reachable
from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError
from tiloilc.diag.text import cells
from tiloilc.ltl import parse, to_text
from tiloilc.ltl.ast import And, Formula, conjunction

ADVANCE = 0.605
"""Width of a character in ems, of the widest of the usual monospaced fonts."""

OPERATOR = re.compile(r" (?:[&|^UWRM]|<?->) ")
"""A binary operator: a formula may be broken before it."""


LOOSEST_FIRST = ("<->", "->", "|", "^", "&", "U", "W", "R", "M")
"""Operators as loosely as they bind."""


def width(lines: Sequence[str], size: float) -> float:
    """The width of the longest line in points, at a font size in points."""
    return max((cells(line) for line in lines), default=0) * ADVANCE * size


def wrapped(text: str, limit: int, lines: int) -> list[str]:
    """`text` in at most `lines` lines of about `limit` characters, cut with … where it is longer.

    Lines are broken before binary operators, inside brackets only where there is no other way;
    words that are too long after an underscore or a hyphen, and cut in their middle if that does
    not help.
    """
    found = [piece for line in _broken(text, limit, -1) for piece in _narrowed(line, limit)]
    return [*found[: lines - 1], f"{found[lines - 1]} …"] if len(found) > lines else found


def _broken(text: str, limit: int, level: int) -> Iterator[str]:
    """Lines of `text`, broken at operators up to `level`, at the next ones in lines too long."""
    operators = list(_operators(text))
    places = [place for place, nested in operators if nested <= level]
    deeper = min((nested for _, nested in operators if nested > level), default=None)
    line = ""
    for start, end in pairwise([0, *places, len(text)]):
        part = text[start:end].strip()
        joined = f"{line} {part}" if line else part
        if line and cells(joined) > limit:
            yield line
            joined = part
        line = joined
        if deeper is not None and cells(line) > limit:
            *whole, line = _broken(line, limit, deeper)
            yield from whole
    yield line


def _operators(text: str) -> Iterator[tuple[int, int]]:
    """The places of the spaces before operators, and how deep inside the formula these are."""
    depth = last = 0
    for match in OPERATOR.finditer(text):
        passed = text[last : match.start()]
        depth += passed.count("(") - passed.count(")")
        last = match.start()
        yield last, depth * len(LOOSEST_FIRST) + LOOSEST_FIRST.index(match[0].strip())


def _narrowed(line: str, limit: int) -> list[str]:
    """A line in pieces none of which is wider than `limit` and a half."""
    if cells(line) <= limit:
        return [line]
    pieces = [""]
    for part in re.split(r"(?<=[_\- ])", line):
        if cells(pieces[-1] + part) <= limit or not pieces[-1]:
            pieces[-1] += part
        else:
            pieces.append(part)
    return [_shortened(piece.rstrip(" "), limit + limit // 2) for piece in pieces]


def _shortened(word: str, limit: int) -> str:
    """`word` without its middle, if it is longer than `limit`."""
    if cells(word) <= limit:
        return word
    kept = (limit - 1) // 2
    return f"{word[:kept]}…{word[-kept:]}"


def own_parts(ldba: Ldba, title: str | None = None) -> list[str]:
    """What sets each state apart: its name without the conjuncts that are nothing new.

    These are conjuncts of all states that follow and of all states that lead here: what is always
    asked is in the title, and so is the name of the first state if it is that formula. A state can
    be left without a text, but not all of them. Names that are no formulas stay as they are.
    """
    live = [b for b in ldba.states if b != ldba.sink]
    formulas = {b: _formula(ldba.names[b], ldba.propositions) for b in live}
    parts = {
        b: f.children if isinstance(f, And) else (f,) for b, f in formulas.items() if f is not None
    }
    if len(parts) < len(live):
        return list(ldba.names)
    follow = [
        [t for t in (*(e.target for e in ldba.outgoing[b]), *ldba.jump_targets[b]) if t in parts]
        for b in ldba.states
    ]
    names = list(ldba.names)
    for b in live:
        near = {*reachable(follow, [b]), *(a for a in live if b in follow[a])}
        own = [part for part in parts[b] if any(part not in parts[c] for c in near)]
        names[b] = to_text(conjunction(own)) if own else ""
    if title is not None and _formula(title, ldba.propositions) == formulas.get(ldba.initial):
        names[ldba.initial] = ""
    return names if any(names[b] for b in live) else list(ldba.names)


def _formula(text: str, propositions: Sequence[str]) -> Formula | None:
    """`text` as a formula over `propositions`; None if it is none."""
    try:
        return parse(text, propositions).formula
    except CompileError:
        return None
