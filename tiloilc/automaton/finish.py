"""From a reduced draft to an `Ldba`: accepting states, the sink, numbers, guards as cubes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import Draft, Row, components, on_cycles
from tiloilc.automaton.guards import as_diagram, text_between
from tiloilc.automaton.ldba import Cube, Edge, Ldba
from tiloilc.automaton.limits import Budget
from tiloilc.automaton.reduction.quotient import quotient
from tiloilc.automaton.reduction.trim import trim


class Copy(NamedTuple):
    """A state of the draft, told apart by whether it was entered over an accepting edge."""

    state: int
    accepting: bool


Successors = Callable[[Copy], list[tuple[Copy, bool, Node]]]


def edge_based(draft: Draft, propositions: tuple[str, ...], diagrams: Diagrams) -> Ldba:
    """The automaton with its accepting marks on edges."""

    def successors(copy: Copy) -> list[tuple[Copy, bool, Node]]:
        row = draft.rows[copy.state]
        return [(Copy(target, False), mark, guard) for (target, mark), guard in row.items()]

    def jumps(copy: Copy) -> list[Copy]:
        return [Copy(target, False) for target in draft.jumps[copy.state]]

    start = Copy(draft.initial, False)
    return _numbered(draft, propositions, diagrams, start, successors, jumps, edges=True)


def state_based(draft: Draft, propositions: tuple[str, ...], diagrams: Diagrams) -> Ldba:
    """The automaton with accepting states, with as few copies as the marks allow.

    A state entered both with and without a mark becomes two, unless one kind can be had for the
    other: marks can go where every cycle has another one, and come where no cycle is unmarked.
    Edges that leave a component are free.
    """
    component, _ = on_cycles(draft)
    draft = _without_spare_marks(draft, component, diagrams)
    quiet = _quiet_components(draft.rows)
    fixed: list[set[bool]] = [set() for _ in draft.rows]
    for q, row in enumerate(draft.rows):
        for target, mark in row:
            if component[q] == component[target] and (mark or quiet[q] == quiet[target]):
                fixed[target].add(mark)

    def copy_of(target: int, mark: bool) -> Copy:
        """The copy to enter: as marked if there is one, the unmarked one if it does not matter."""
        kinds = fixed[target] or {False}
        return Copy(target, mark if mark in kinds else not mark)

    def successors(copy: Copy) -> list[tuple[Copy, bool, Node]]:
        row = draft.rows[copy.state]
        return [(copy_of(target, mark), False, guard) for (target, mark), guard in row.items()]

    def jumps(copy: Copy) -> list[Copy]:
        return [copy_of(target, False) for target in draft.jumps[copy.state]]

    start = copy_of(draft.initial, False)
    return _numbered(draft, propositions, diagrams, start, successors, jumps, edges=False)


def _without_spare_marks(draft: Draft, component: Sequence[int], diagrams: Diagrams) -> Draft:
    """`draft` with no marks on the edges into a state that has unmarked ones, where it may be so.

    A mark may go if every cycle through its edge has another one.
    """
    rows = list(draft.rows)
    for target in range(len(rows)):
        inside = [q for q, row in enumerate(rows) if component[q] == component[target]]
        kinds = {mark for q in inside for t, mark in rows[q] if t == target}
        if len(kinds) < 2:
            continue
        bare = [
            _unmarked_into(row, target, diagrams) if q in inside else row
            for q, row in enumerate(rows)
        ]
        quiet = _quiet_components(bare)
        if not any(quiet[q] == quiet[target] for q in inside if (target, True) in rows[q]):
            rows = bare
    return replace(draft, rows=tuple(rows))


def _unmarked_into(row: Row, target: int, diagrams: Diagrams) -> Row:
    """`row` with its edges to `target` as one without a mark."""
    into = diagrams.disj(row.get((target, True), FALSE), row.get((target, False), FALSE))
    others = {key: guard for key, guard in row.items() if key[0] != target}
    return others if into == FALSE else others | {(target, False): into}


def _quiet_components(rows: Sequence[Row]) -> list[int]:
    """The component of each state in the graph of unmarked edges."""
    return components([[t for t, mark in row if not mark] for row in rows])


def _numbered(
    draft: Draft,
    propositions: tuple[str, ...],
    diagrams: Diagrams,
    start: Copy,
    successors: Successors,
    jumps: Callable[[Copy], list[Copy]],
    edges: bool,
) -> Ldba:
    """Number the states breadth first, letters in the order of the propositions, the sink last."""
    if not any(mark for row in draft.rows for _, mark in row):
        return _empty(propositions)
    index = {start: 0}
    order = [start]
    rows: list[list[tuple[Copy, bool, Node]]] = []
    for copy in order:
        diagrams.budget.tick()
        row = sorted(successors(copy), key=lambda edge: diagrams.first_letter(edge[2]))
        rows.append(row)
        for target in (*(t for t, _, _ in row), *jumps(copy)):
            if target not in index:
                index[target] = len(order)
                order.append(target)
    found: list[Edge] = []
    marked: set[tuple[int, int, tuple[Cube, ...]]] = set()
    sink = len(order)
    for number, row in enumerate(rows):
        missing = TRUE
        together: dict[tuple[int, bool], Node] = {}
        for target, mark, guard in row:
            missing = diagrams.minus(missing, guard)
            key = (index[target], mark)
            together[key] = diagrams.disj(together.get(key, FALSE), guard)
        if missing != FALSE:
            together[sink, False] = missing
        for (target_number, mark), guard in together.items():
            edge = Edge(number, target_number, cubes(diagrams, guard))
            found.append(edge)
            if mark:
                marked.add((edge.source, edge.target, edge.guard))
    names = [_name(draft, copy.state, propositions, diagrams) for copy in order]
    complete = all(edge.target != sink for edge in found)
    if not complete:
        found.append(Edge(sink, sink, (Cube(0, 0),)))
        names.append("false")
    found.sort()
    return Ldba(
        propositions=propositions,
        names=tuple(names),
        accepting=frozenset(index[c] for c in order if c.accepting and not edges),
        sink=None if complete else sink,
        edges=tuple(found),
        jumps=tuple(sorted((index[c], index[t]) for c in order for t in jumps(c))),
        accepting_edges=frozenset(
            i for i, e in enumerate(found) if (e.source, e.target, e.guard) in marked
        ),
    )


def _name(draft: Draft, state: int, propositions: Sequence[str], diagrams: Diagrams) -> str:
    """The name of `state`; one that does nothing but stay is called `G a` after its letters."""
    name = draft.names[state]
    if name is not None:
        return name()
    guard = next(iter(draft.rows[state].values()))
    text = text_between(diagrams, guard, guard, propositions)
    return f"G ({text})" if " " in text else f"G {text}"


def _empty(propositions: tuple[str, ...]) -> Ldba:
    """The automaton that accepts nothing: the sink alone."""
    edge = Edge(0, 0, (Cube(0, 0),))
    return Ldba(propositions, ("false",), frozenset(), 0, (edge,))


def cubes(diagrams: Diagrams, guard: Node) -> tuple[Cube, ...]:
    """An irredundant cover of a set of letters, sorted."""
    found = []
    for literals in diagrams.cover(guard):
        mask = sum(1 << v for v, _ in literals)
        found.append(Cube(mask, sum(1 << v for v, sign in literals if sign)))
    return tuple(sorted(found))


def draft_of(ldba: Ldba, diagrams: Diagrams) -> Draft:
    """`ldba` as a draft again: marks on the edges that accept, nothing that leads to the sink."""
    rows: list[Row] = [{} for _ in ldba.states]
    for index, edge in enumerate(ldba.edges):
        if edge.target != ldba.sink and edge.source != ldba.sink:
            key = (edge.target, ldba.is_marked(index))
            guard = as_diagram(diagrams, edge.guard)
            rows[edge.source][key] = diagrams.disj(rows[edge.source].get(key, FALSE), guard)
    names = tuple(partial(str, text) for text in ldba.names)
    return Draft(tuple(rows), ldba.jump_targets, ldba.initial, names)


def with_edge_acceptance(ldba: Ldba) -> Ldba:
    """`ldba` with marks on the edges into its accepting states, and what then agrees merged."""
    if ldba.accepting_edges or not ldba.accepting:
        return ldba
    diagrams = Diagrams(Budget())
    draft = quotient(trim(draft_of(ldba, diagrams), diagrams), diagrams)
    return edge_based(draft, ldba.propositions, diagrams)
