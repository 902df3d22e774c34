"""From a HOA file to an automaton that is deterministic once it accepts, or to why it is not.

Keep what can accept; find out after which states every letter leads to one place only; make one
kind of marks of several (generalised Büchi acceptance).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from tiloilc.automaton.bdd import FALSE, Diagrams, Node
from tiloilc.automaton.draft import Row, components
from tiloilc.automaton.finish import cubes
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.hoa.body import Body, FileState
from tiloilc.diag import CompileError, Diagnostic

Marks = int
"""Bit i: the edge is in the i-th set, each of which must be visited infinitely often."""

MarkedRow = dict[tuple[int, Marks], Node]
"""The edges of a state: letters by target and marks; those of one target do not overlap."""

BEGIN = -1
"""The number of the state that is made where a file has several beginnings."""


@dataclass(frozen=True)
class Limited:
    """A limit-deterministic automaton, without what cannot accept.

    States 0, 1, … are the `fixed` ones: from there on no letter ever leads to two places. The
    `free` ones follow: letters by target, which may overlap and lead to states of both kinds.
    `origin[q]` is the number in the file of state q. Several fixed states can have one origin:
    they wait for different sets of marks and accept the same words. The first is entered.
    """

    fixed: tuple[Row, ...]
    free: tuple[dict[int, Node], ...]
    initial: int
    origin: tuple[int, ...]

    @property
    def entry(self) -> dict[int, int]:
        """By origin, the state that is entered."""
        return {n: q for q, n in reversed(list(enumerate(self.origin)))}


def limited(body: Body) -> Limited | None:
    """The automaton of a file; None if it accepts nothing.

    Raises CompileError AUT304 where a letter leads to two places after acceptance.
    """
    diagrams, sets = body.diagrams, len(body.header.clauses)
    rows = {n: _row(body, state, _on_states(body)) for n, state in sorted(body.states.items())}
    starts = [n for n, _ in body.header.starts]
    initial = starts[0] if len(starts) == 1 else BEGIN
    if len(starts) > 1:
        rows = {BEGIN: _beginning([rows[n] for n in starts], diagrams), **rows}
    lasting = _accepting_components(rows, sets)
    live = _reach(_turned(_graph(rows)), lasting)
    if initial not in live:
        return None
    rows = {n: _kept(row, lasting.get(n), lasting, live, diagrams) for n, row in rows.items()}
    rows = {n: row for n, row in rows.items() if n in live}
    choosing = {n for n, row in rows.items() if _overlap(row, diagrams) is not None}
    _check(body, rows, initial, choosing, lasting)
    free = _reach(_turned(_graph(rows)), choosing)
    kinds = sorted(free & _reach(_graph(rows), [initial])), sorted(set(rows) - free)
    return _degeneralised(rows, *kinds, lasting, initial, sets, diagrams)


def _graph(rows: Mapping[int, MarkedRow]) -> dict[int, list[int]]:
    """Where each state leads."""
    return {n: [target for target, _ in row] for n, row in rows.items()}


def _turned(graph: Mapping[int, list[int]]) -> dict[int, list[int]]:
    """The graph with all edges turned round."""
    back: dict[int, list[int]] = {n: [] for n in graph}
    for n, targets in graph.items():
        for target in targets:
            back[target].append(n)
    return back


def _reach(graph: Mapping[int, list[int]], starts: Iterable[int]) -> set[int]:
    """The states that can be reached from `starts`, these included."""
    found = set(starts)
    work = list(found)
    while work:
        for target in graph[work.pop()]:
            if target not in found:
                found.add(target)
                work.append(target)
    return found


def _on_states(body: Body) -> bool:
    """Whether marks are on states only: then the edges into them are taken as marked."""
    return not any(state.marked for state in body.states.values())


def _row(body: Body, state: FileState, on_states: bool) -> MarkedRow:
    """The edges of a state; of two to one target on one letter, the marks are put together.

    A run that may choose between them for ever loses nothing by having both.
    """
    diagrams = body.diagrams
    together: dict[tuple[int, Marks], Node] = {}
    for edge in state.edges:
        diagrams.budget.tick()
        sets = body.states[edge.target].sets if on_states else edge.sets
        marks = 0
        for i, clause in enumerate(body.header.clauses):
            marks |= any((v.number in sets) != v.outside for v in clause) << i
        key = (edge.target, marks)
        together[key] = diagrams.disj(together.get(key, FALSE), edge.guard)
    return _disjoint(together, diagrams)


def _disjoint(edges: Mapping[tuple[int, Marks], Node], diagrams: Diagrams) -> MarkedRow:
    parts: dict[int, dict[Marks, Node]] = {}
    for (target, marks), guard in edges.items():
        found = parts.setdefault(target, {})
        for other, letters in list(found.items()):
            diagrams.budget.tick()
            both = diagrams.conj(letters, guard)
            if both != FALSE:
                found[other] = diagrams.minus(letters, both)
                guard = diagrams.minus(guard, both)
                joined = marks | other
                found[joined] = diagrams.disj(found.get(joined, FALSE), both)
        found[marks] = diagrams.disj(found.get(marks, FALSE), guard)
    return {
        (target, marks): guard
        for target, found in parts.items()
        for marks, guard in found.items()
        if guard != FALSE
    }


def _beginning(rows: Iterable[MarkedRow], diagrams: Diagrams) -> MarkedRow:
    """The edges of all `rows`, unmarked: nothing comes back to the beginning."""
    together: MarkedRow = {}
    for row in rows:
        for (target, _), guard in row.items():
            together[target, 0] = diagrams.disj(together.get((target, 0), FALSE), guard)
    return together


def _accepting_components(rows: Mapping[int, MarkedRow], sets: int) -> dict[int, int]:
    """The component of each state from which one can go round through all sets of marks."""
    numbers = list(rows)
    place = {n: i for i, n in enumerate(numbers)}
    component = components([[place[t] for t, _ in rows[n]] for n in numbers])
    seen: dict[int, Marks] = {}
    for n, row in rows.items():
        for target, marks in row:
            if component[place[n]] == component[place[target]]:
                here = component[place[n]]
                seen[here] = seen.get(here, 0) | marks
    every = (1 << sets) - 1
    return {n: c for n in numbers if seen.get(c := component[place[n]], -1) == every}


def _kept(
    row: MarkedRow,
    here: int | None,
    lasting: Mapping[int, int],
    live: set[int],
    diagrams: Diagrams,
) -> MarkedRow:
    """The edges to live states, with marks only inside an accepting component."""
    new: MarkedRow = {}
    for (target, marks), guard in row.items():
        if target in live:
            inside = here is not None and lasting.get(target) == here
            key = (target, marks if inside else 0)
            new[key] = diagrams.disj(new.get(key, FALSE), guard)
    return new


def _overlap(row: MarkedRow, diagrams: Diagrams) -> tuple[int, int, Node] | None:
    """Two targets of the same letters, and these letters."""
    seen = FALSE
    for (target, _), guard in row.items():
        both = diagrams.conj(seen, guard)
        if both != FALSE:
            for (other, _), letters in row.items():
                common = diagrams.conj(letters, guard)
                if other != target and common != FALSE:
                    return other, target, common
        seen = diagrams.disj(seen, guard)
    return None


def _check(
    body: Body,
    rows: Mapping[int, MarkedRow],
    initial: int,
    choosing: set[int],
    lasting: Mapping[int, int],
) -> None:
    """Raise CompileError AUT304 if the automaton can choose after it accepted."""
    graph = _graph(rows)
    accepting = _reach(graph, [initial]) & set(lasting)
    wrong = sorted(_reach(graph, accepting) & choosing)
    if not wrong:
        return
    state, diagrams = body.states[wrong[0]], body.diagrams
    found = _overlap(rows[wrong[0]], diagrams)
    assert found is not None
    first, second, letters = found
    guard = guard_text(cubes(diagrams, letters), body.header.propositions)
    edge = next(
        e for e in state.edges if e.target == second and diagrams.conj(e.guard, letters) != FALSE
    )
    where = _shown(body, wrong[0])
    targets = " and to ".join(str(n) for n in (first, second))
    problem = f"after acceptance, {where} goes to {targets} on `{guard}`"
    raise CompileError(
        Diagnostic.of(
            "AUT304",
            body.tokens.span(edge.place.start, edge.place.end),
            label=f"`{guard}` leads to state {first}, too",
            help="make it deterministic, for example with Owl's `ltl2ldba`",
            problem=problem,
        )
    )


def _shown(body: Body, number: int) -> str:
    name = body.states[number].name
    quoted = f" (`{name}`)" if name and name.isprintable() and len(name) < 40 else ""
    return f"state {number}{quoted}"


def _degeneralised(
    rows: Mapping[int, MarkedRow],
    free: Sequence[int],
    fixed: Sequence[int],
    lasting: Mapping[int, int],
    initial: int,
    sets: int,
    diagrams: Diagrams,
) -> Limited:
    """One set of marks: a fixed state waits for the sets in turn, and accepts after the last."""
    copies = [(n, 0) for n in fixed]
    index = {copy: q for q, copy in enumerate(copies)}
    done: list[Row] = []
    while len(done) < len(copies):
        number, turn = copies[len(done)]
        diagrams.budget.states(len(copies))
        row: Row = {}
        for (target, marks), guard in rows[number].items():
            following, accepts = 0, False
            if number in lasting and lasting[number] == lasting.get(target):
                following, accepts = _turn(turn, marks, sets)
            copy = (target, following)
            if copy not in index:
                index[copy] = len(copies)
                copies.append(copy)
            key = (index[copy], accepts)
            row[key] = diagrams.disj(row.get(key, FALSE), guard)
        done.append(row)
    numbers = {n: index[n, 0] for n in fixed} | {n: len(copies) + i for i, n in enumerate(free)}
    waiting: list[dict[int, Node]] = []
    for number in free:
        edges: dict[int, Node] = {}
        for (target, _), guard in rows[number].items():
            edges[numbers[target]] = diagrams.disj(edges.get(numbers[target], FALSE), guard)
        waiting.append(edges)
    origin = (*(n for n, _ in copies), *free)
    return Limited(tuple(done), tuple(waiting), numbers[initial], origin)


def _turn(turn: int, marks: Marks, sets: int) -> tuple[int, bool]:
    """The set that is waited for after an edge with `marks`, and whether a round is complete."""
    complete = sets == 0
    while marks >> turn & 1:
        turn += 1
        if turn == sets:
            turn = 0
            if complete:
                break
            complete = True
    return turn, complete
