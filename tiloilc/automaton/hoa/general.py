"""From a HOA file to an automaton that is deterministic once it accepts, or to why it is not.

Keep what can accept; find out after which states every letter leads to one place only; make one
kind of marks of several (generalised Büchi acceptance).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tiloilc.automaton.bdd import FALSE, Diagrams, Node
from tiloilc.automaton.draft import Row, components, reachable
from tiloilc.automaton.finish import cubes
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.hoa.body import Body
from tiloilc.automaton.hoa.rows import MarkedRow, Marks, readings
from tiloilc.diag import CompileError, Diagnostic


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
    wrong: CompileError | None = None
    for written, initial in readings(body):
        lasting = _accepting_components(written, sets)
        live = reachable(_turned(_graph(written)), lasting)
        if initial not in live:
            return None
        rows = {n: _kept(written[n], lasting.get(n), lasting, live, diagrams) for n in written}
        rows = {n: row for n, row in rows.items() if n in live}
        choosing = {n for n, row in rows.items() if _overlap(row, diagrams) is not None}
        reached = reachable(_graph(rows), [initial])
        choices = reachable(_graph(rows), reached & set(lasting)) & choosing
        if choices:
            wrong = wrong or _wrong(body, rows, min(choices))
            continue
        free = reachable(_turned(_graph(rows)), choosing)
        kinds = sorted(free & reached), sorted(set(rows) - free)
        return _degeneralised(rows, *kinds, lasting, initial, sets, diagrams)
    assert wrong is not None
    raise wrong


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


def _wrong(body: Body, rows: Mapping[int, MarkedRow], number: int) -> CompileError:
    """AUT304: the state `number`, reached after acceptance, chooses."""
    state, diagrams = body.states[number], body.diagrams
    found = _overlap(rows[number], diagrams)
    assert found is not None
    first, second, letters = found
    guard = guard_text(cubes(diagrams, letters), body.header.propositions)
    edge = next(
        e for e in state.edges if e.target == second and diagrams.conj(e.guard, letters) != FALSE
    )
    where = _shown(body, number)
    problem = f"after acceptance, {where} goes to {first} and to {second} on `{guard}`"
    return CompileError(
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
