"""Passes that make an automaton smaller and keep its language, and the order they run in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import (
    Draft,
    Row,
    components,
    keep,
    on_cycles,
    reachable,
    reversed_graph,
)

MAX_PAIRS = 4_000
"""Pairs of states to compare by language: beyond, inclusion costs more than it saves."""

MAX_ROUNDS = 20
"""The passes shrink the automaton until nothing changes; this bounds the rounds all the same."""

DEAD = -1


def trim(draft: Draft, diagrams: Diagrams) -> Draft:
    """Drop what cannot be reached and what cannot accept, and accepting marks on no cycle."""
    graph = [draft.targets(q) for q in range(len(draft.rows))]
    component = components(graph)
    rows: list[Row] = []
    accepting = set()
    for q, row in enumerate(draft.rows):
        new: Row = {}
        for (target, mark), guard in row.items():
            key = (target, mark and component[q] == component[target])
            new[key] = diagrams.disj(new.get(key, FALSE), guard)
            if key[1]:
                accepting.add(q)
        rows.append(new)
    live = reachable(reversed_graph(graph), accepting)
    kept = (live & reachable(graph, [draft.initial])) | {draft.initial}
    trimmed = keep(replace(draft, rows=tuple(rows)), kept)
    if len(kept) < len(draft.rows):
        return trim(trimmed, diagrams)
    return trimmed


def delay_jumps(draft: Draft, diagrams: Diagrams) -> Draft:
    """Move jumps from or to a state on no cycle one letter on, until none is left.

    The language of a jump's target is part of its source's, so a jump one letter later is allowed
    wherever the source's successor can be reached; states that no jump needs any more go.
    """
    _, looping = on_cycles(draft)
    waiting = waiting_states(draft)
    jumps = [dict.fromkeys(targets) for targets in draft.jumps]
    work = [(q, t) for q in range(len(jumps)) for t in jumps[q]]
    done = set(work)
    while work:
        diagrams.budget.tick()
        source, target = work.pop()
        if looping[source] and looping[target]:
            continue
        del jumps[source][target]
        for (s, _), guard in draft.rows[source].items():
            for (t, _), other in draft.rows[target].items():
                if s == t or s not in waiting or diagrams.conj(guard, other) == FALSE:
                    continue
                jumps[s].setdefault(t)
                if (s, t) not in done:
                    done.add((s, t))
                    work.append((s, t))
    return replace(draft, jumps=tuple(tuple(sorted(targets)) for targets in jumps))


def waiting_states(draft: Draft) -> set[int]:
    """The states from which a jump can still be taken."""
    graph = [draft.targets(q) for q in range(len(draft.rows))]
    return reachable(reversed_graph(graph), [q for q, t in enumerate(draft.jumps) if t])


def quotient(draft: Draft, diagrams: Diagrams) -> Draft:
    """Merge bisimilar states: same letters to the same classes with the same marks, same jumps."""
    block = [0] * len(draft.rows)
    count = 1
    while True:
        signatures: dict[object, int] = {}
        refined = []
        for q, row in enumerate(draft.rows):
            diagrams.budget.tick()
            signature = (
                block[q],
                frozenset(merged_row(row, block, diagrams).items()),
                frozenset(block[t] for t in draft.jumps[q]),
            )
            refined.append(signatures.setdefault(signature, len(signatures)))
        block = refined
        if len(signatures) == count:
            break
        count = len(signatures)
    first: dict[int, int] = {}
    for q, number in enumerate(block):
        first.setdefault(number, q)
    return replace(
        draft,
        rows=tuple(merged_row(draft.rows[q], block, diagrams) for q in first.values()),
        jumps=tuple(
            tuple(sorted({block[t] for t in draft.jumps[q]} - {block[q]})) for q in first.values()
        ),
        initial=block[draft.initial],
        names=tuple(draft.names[q] for q in first.values()),
    )


def merged_row(row: Row, block: Sequence[int], diagrams: Diagrams) -> Row:
    """`row` with targets replaced by `block[target]`."""
    new: Row = {}
    for (target, mark), guard in row.items():
        key = (block[target], mark)
        new[key] = diagrams.disj(new.get(key, FALSE), guard)
    return new


class Inclusion:
    """Which pairs (left, right) have L(left) ⊆ L(right); right ones must be deterministic.

    `left` goes with its jumps. A word that is accepted on the left and not on the right leads, in
    the product, to a cycle that is marked on the left only, or to a dead right side.
    """

    def __init__(self, draft: Draft, diagrams: Diagrams, pairs: Sequence[tuple[int, int]]) -> None:
        self._diagrams = diagrams
        self._draft = draft
        self._index: dict[tuple[int, int], int] = {}
        self.complete = True
        graph = self._explore(pairs)
        quiet = [[t for t, _, right in edges if not right] for edges in graph]
        component = components(quiet)
        bad = {
            q
            for q, edges in enumerate(graph)
            for t, left, right in edges
            if left and not right and component[q] == component[t]
        }
        bad |= {q for (_, right), q in self._index.items() if right == DEAD}
        back = reversed_graph([[t for t, _, _ in edges] for edges in graph])
        self._bad = reachable(back, bad)

    def _explore(self, pairs: Sequence[tuple[int, int]]) -> list[list[tuple[int, bool, bool]]]:
        work = list(dict.fromkeys(pairs))
        self._index.update({pair: i for i, pair in enumerate(work)})
        graph: list[list[tuple[int, bool, bool]]] = []
        for pair in work:
            if len(work) > MAX_PAIRS:
                self.complete = False
                break
            edges = []
            for target, left, right in self._steps(*pair):
                if target not in self._index:
                    self._index[target] = len(work)
                    work.append(target)
                edges.append((self._index[target], left, right))
            graph.append(edges)
        graph.extend([] for _ in range(len(work) - len(graph)))
        return graph

    def _steps(self, left: int, right: int) -> list[tuple[tuple[int, int], bool, bool]]:
        if right == DEAD:
            return []
        conj = self._diagrams.conj
        edges = []
        for state in (left, *self._draft.jumps[left]):
            for (target, mark), guard in self._draft.rows[state].items():
                self._diagrams.budget.tick()
                missing = guard
                for (other, other_mark), letters in self._draft.rows[right].items():
                    if conj(guard, letters) != FALSE:
                        edges.append(((target, other), mark, other_mark))
                        missing = self._diagrams.minus(missing, letters)
                if missing != FALSE:
                    edges.append(((target, DEAD), mark, False))
        return edges

    def holds(self, left: int, right: int) -> bool:
        """Whether L(left) ⊆ L(right); False also where it was too much to find out."""
        return self.complete and self._index[left, right] not in self._bad


def merge_by_language(draft: Draft, diagrams: Diagrams) -> Draft:
    """Lead what enters a state to one of the same language further on, if there is one.

    Only towards deterministic states of a component that comes later in a fixed order, so that a
    run is redirected finitely often. A waiting state whose jump covers its language becomes that
    jump's target: there was nothing to guess.
    """
    component, looping = on_cycles(draft)
    waiting = waiting_states(draft)
    fixed = [q for q in range(len(draft.rows)) if q not in waiting]
    pairs = [(q, t) for q in sorted(waiting) for t in draft.jumps[q]]
    pairs += [(q, t) for q in fixed for t in fixed if component[q] != component[t]]
    if len(pairs) > MAX_PAIRS:
        return draft
    inclusion = Inclusion(draft, diagrams, pairs)
    known = set(pairs)
    block = list(range(len(draft.rows)))
    for q in block:
        same = [
            t
            for t in fixed
            if (q, t) in known
            and component[t] < component[q]
            and inclusion.holds(q, t)
            and (q in waiting or inclusion.holds(t, q))
        ]
        if same:
            block[q] = min(same, key=lambda t: (component[t], not looping[t], t))
    if block == list(range(len(block))):
        return draft
    return replace(
        draft,
        rows=tuple(merged_row(row, block, diagrams) for row in draft.rows),
        jumps=tuple(tuple(sorted({block[t] for t in targets})) for targets in draft.jumps),
        initial=block[draft.initial],
    )


def drop_jumps(draft: Draft, diagrams: Diagrams) -> Draft:
    """Drop a jump if another one of the same state covers its language."""
    pairs = [(s, t) for targets in draft.jumps for s in targets for t in targets if s != t]
    if not pairs or len(pairs) > MAX_PAIRS:
        return draft
    inclusion = Inclusion(draft, diagrams, pairs)
    jumps = []
    for targets in draft.jumps:
        kept = list(targets)
        for target in reversed(targets):
            others = [t for t in kept if t != target]
            if any(inclusion.holds(target, t) for t in others):
                kept = others
        jumps.append(tuple(kept))
    return replace(draft, jumps=tuple(jumps))


Pass = Callable[[Draft, Diagrams], Draft]

PASSES: tuple[Pass, ...] = (trim, quotient, delay_jumps, trim, drop_jumps, merge_by_language, trim)
"""In this order, again and again while they shrink the automaton."""


def reduce(draft: Draft, diagrams: Diagrams) -> Draft:
    """Run all passes until nothing gets smaller."""
    for _ in range(MAX_ROUNDS):
        before = _size(draft)
        for step in PASSES:
            draft = step(draft, diagrams)
        if _size(draft) == before:
            break
    return draft


def _size(draft: Draft) -> tuple[int, int, int]:
    return (
        len(draft.rows),
        sum(len(targets) for targets in draft.jumps),
        sum(len(row) for row in draft.rows),
    )
