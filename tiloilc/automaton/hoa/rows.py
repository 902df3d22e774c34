"""The edges of a HOA file's states as letters by target and marks, in the ways they can be read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from tiloilc.automaton.bdd import FALSE, Diagrams, Node
from tiloilc.automaton.hoa.body import Body, FileState

Marks = int
"""Bit i: the edge is in the i-th set, each of which must be visited infinitely often."""

MarkedRow = dict[tuple[int, Marks], Node]
"""The edges of a state: letters by target and marks; those of one target do not overlap."""

BEGIN = -1
"""The number of the state that is made where a file has several beginnings."""


def readings(body: Body) -> Iterator[tuple[dict[int, MarkedRow], int]]:
    """The rows of all states and the initial state: as written, then with labels moved.

    Where labels are on states, a state reads its own letter, and several states may follow of
    which the next letter chooses one. So the same words are accepted if an edge reads the letter of
    the state that it enters, and the first letter is read on entering a beginning.
    """
    on_states = not any(state.marked for state in body.states.values())
    rows = {n: _row(body, state, on_states) for n, state in sorted(body.states.items())}
    starts = [n for n, _ in body.header.starts]
    if len(starts) == 1:
        yield rows, starts[0]
    else:
        yield {BEGIN: _beginning([rows[n] for n in starts], body.diagrams), **rows}, BEGIN
    if all(state.labelled == "state" for state in body.states.values()):
        label = {n: s.edges[0].guard if s.edges else FALSE for n, s in body.states.items()}
        begin: MarkedRow = {(n, 0): label[n] for n in starts}
        moved = {n: {(t, m): label[t] for t, m in row} for n, row in rows.items()}
        yield {n: _possible(row) for n, row in {BEGIN: begin, **moved}.items()}, BEGIN


def _possible(row: MarkedRow) -> MarkedRow:
    return {key: guard for key, guard in row.items() if guard != FALSE}


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
        for other in list(found):
            diagrams.budget.tick()
            both = diagrams.conj(found[other], guard)
            if both != FALSE:
                found[other] = diagrams.minus(found[other], both)
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
