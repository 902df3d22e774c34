"""A strict reader of HOA v1 with Büchi acceptance, written from the format's grammar alone.

http://adl.github.io/hoaf: it reads what the grammar allows for explicit labels on edges, refuses
everything else, and checks each property that the header claims.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

from tiloilc.ltl import Lasso

TOKEN = re.compile(
    r'\s+|(?P<string>"(?:\\.|[^"\\])*")|(?P<section>--(?:BODY|END|ABORT)--)'
    r"|(?P<header>[a-zA-Z_][0-9a-zA-Z_-]*:)|(?P<word>[a-zA-Z_][0-9a-zA-Z_-]*)"
    r"|(?P<int>0|[1-9][0-9]*)|(?P<sign>[\[\]{}()&|!])"
)


@dataclass
class Hoa:
    """A nondeterministic Büchi automaton; marks of states are put on their outgoing edges."""

    headers: dict[str, list[str]] = field(default_factory=dict)
    names: dict[int, str] = field(default_factory=dict)
    edges: dict[int, list[tuple[frozenset[int], int, bool]]] = field(default_factory=dict)
    state_marks: set[int] = field(default_factory=set)
    start: int = 0
    propositions: tuple[str, ...] = ()

    def accepts(self, lasso: Lasso) -> bool:
        """Whether some run goes round a marked cycle: by plain search."""
        letters, back = lasso.letters, len(lasso.stem)

        def moves(place: tuple[int, int]) -> list[tuple[tuple[int, int], bool]]:
            state, position = place
            following = position + 1 if position + 1 < len(letters) else back
            return [
                ((target, following), mark)
                for guard, target, mark in self.edges[state]
                if letters[position] in guard
            ]

        def reach(start: tuple[int, int]) -> set[tuple[int, int]]:
            found, work = {start}, [start]
            while work:
                for target, _ in moves(work.pop()):
                    if target not in found:
                        found.add(target)
                        work.append(target)
            return found

        return any(
            mark and place in reach(target)
            for place in reach((self.start, 0))
            for target, mark in moves(place)
        )


class Reader:
    """Tokens one after the other."""

    def __init__(self, text: str) -> None:
        self.tokens: list[tuple[str, str]] = []
        position = 0
        while position < len(text):
            match = TOKEN.match(text, position)
            assert match, f"not a token: {text[position : position + 20]!r}"
            position = match.end()
            if match.lastgroup:
                self.tokens.append((match.lastgroup, match.group(match.lastgroup)))
        self.place = 0

    def peek(self) -> tuple[str, str]:
        return self.tokens[self.place] if self.place < len(self.tokens) else ("end", "")

    def take(self, kind: str, value: str | None = None) -> str:
        found_kind, found = self.peek()
        assert found_kind == kind, f"expected {kind}, found {found!r}"
        assert value is None or found == value, f"expected {value}, found {found!r}"
        self.place += 1
        return found

    def label(self, count: int) -> frozenset[int]:
        """label-expr: | binds less than &, that less than !."""
        letters = self._conjunction(count)
        while self.peek() == ("sign", "|"):
            self.take("sign")
            letters |= self._conjunction(count)
        return letters

    def _conjunction(self, count: int) -> frozenset[int]:
        letters = self._literal(count)
        while self.peek() == ("sign", "&"):
            self.take("sign")
            letters &= self._literal(count)
        return letters

    def _literal(self, count: int) -> frozenset[int]:
        every = frozenset(range(2**count))
        kind, value = self.peek()
        if (kind, value) == ("sign", "!"):
            self.take("sign")
            return every - self._literal(count)
        if (kind, value) == ("sign", "("):
            self.take("sign")
            inside = self.label(count)
            self.take("sign", ")")
            return inside
        if kind == "word":
            assert value in ("t", "f"), f"not a label: {value}"
            self.take("word")
            return every if value == "t" else frozenset()
        bit = int(self.take("int"))
        assert bit < count, "a label names a proposition that is not in AP"
        return frozenset(letter for letter in every if letter >> bit & 1)


def read_hoa(text: str) -> Hoa:
    """Read one automaton. AssertionError where the text breaks the grammar or its own claims."""
    reader, hoa = Reader(text), Hoa()
    assert reader.take("header") == "HOA:"
    assert reader.take("word") == "v1"
    while reader.peek()[0] == "header":
        name = reader.take("header")[:-1]
        assert name not in hoa.headers, f"{name} twice"
        values = hoa.headers[name] = []
        while reader.peek()[0] in ("int", "string", "word", "sign"):
            values.append(reader.take(reader.peek()[0]))
    count = int(hoa.headers["AP"][0])
    hoa.propositions = tuple(_unquoted(text) for text in hoa.headers["AP"][1:])
    assert len(set(hoa.propositions)) == len(hoa.propositions) == count
    assert hoa.headers["Acceptance"] == ["1", "Inf", "(", "0", ")"]
    assert hoa.headers["acc-name"] == ["Buchi"]
    (start,) = hoa.headers["Start"]
    (states,) = hoa.headers["States"]
    hoa.start = int(start)
    reader.take("section", "--BODY--")
    while reader.peek() == ("header", "State:"):
        _read_state(reader, hoa, count)
    reader.take("section", "--END--")
    assert reader.peek()[0] == "end"
    assert sorted(hoa.edges) == list(range(int(states))), "each state once"
    assert hoa.start in hoa.edges
    assert all(t in hoa.edges for edges in hoa.edges.values() for _, t, _ in edges)
    _check_properties(hoa, count)
    return hoa


def _read_state(reader: Reader, hoa: Hoa, count: int) -> None:
    reader.take("header")
    state = int(reader.take("int"))
    assert state not in hoa.edges
    if reader.peek()[0] == "string":
        hoa.names[state] = _unquoted(reader.take("string"))
    marked = _marks(reader)
    if marked:
        hoa.state_marks.add(state)
    edges = hoa.edges[state] = []
    while reader.peek() == ("sign", "["):
        reader.take("sign")
        guard = reader.label(count)
        reader.take("sign", "]")
        target = int(reader.take("int"))
        edges.append((guard, target, _marks(reader) or marked))


def _marks(reader: Reader) -> bool:
    if reader.peek() != ("sign", "{"):
        return False
    reader.take("sign")
    reader.take("int", "0")
    reader.take("sign", "}")
    return True


def _check_properties(hoa: Hoa, count: int) -> None:
    """Every claim must hold, and determinism must not be hidden."""
    claims = set(hoa.headers["properties"])
    every = frozenset(range(2**count))
    deterministic = {q for q, edges in hoa.edges.items() if _disjoint([g for g, _, _ in edges])}
    complete = all(every == frozenset().union(*(g for g, _, _ in e)) for e in hoa.edges.values())
    reach = {q: _reach(hoa, [q]) for q in hoa.edges}
    cycles = {
        (q, mark)
        for q, edges in hoa.edges.items()
        for _, target, mark in edges
        if q in reach[target]
    }
    after_acceptance = _reach(hoa, sorted({q for q, mark in cycles if mark}))
    assert claims <= {
        "trans-labels", "explicit-labels", "trans-acc", "state-acc", "complete", "deterministic",
        "unambiguous", "semi-deterministic", "weak",
    }  # fmt: skip
    assert {"trans-labels", "explicit-labels"} <= claims
    assert ("deterministic" in claims) == (len(deterministic) == len(hoa.edges))
    assert ("complete" in claims) == complete
    assert ("semi-deterministic" in claims) == (after_acceptance <= deterministic)
    assert "unambiguous" not in claims or "deterministic" in claims
    assert ("state-acc" in claims) != ("trans-acc" in claims)
    if "trans-acc" in claims:
        assert not hoa.state_marks
    if "state-acc" in claims:
        assert all(m == (q in hoa.state_marks) for q, e in hoa.edges.items() for _, _, m in e)
    unmarked = {q for q, mark in cycles if not mark}
    mixed = any(s in reach[q] and q in reach[s] for q, m in cycles if m for s in unmarked)
    assert ("weak" in claims) == (not mixed), "a component has marked and unmarked edges"


def _reach(hoa: Hoa, starts: Sequence[int]) -> set[int]:
    found, work = set(starts), list(starts)
    while work:
        for _, target, _ in hoa.edges[work.pop()]:
            if target not in found:
                found.add(target)
                work.append(target)
    return found


def _disjoint(guards: Sequence[frozenset[int]]) -> bool:
    return all(not (a & b) for (i, a), (j, b) in product(enumerate(guards), repeat=2) if i < j)


def _unquoted(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text[1:-1])
