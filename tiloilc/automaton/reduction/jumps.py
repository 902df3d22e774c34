"""Fewer jumps: later ones instead of those from or to states on no cycle, none that adds nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import Draft, components, on_cycles, reachable, reversed_graph
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion


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


def drop_jumps(draft: Draft, diagrams: Diagrams) -> Draft:
    """Drop the jumps that an agent never misses: whatever they accept, others accept later.

    The jump from q to t goes if q without it can follow t: wait on, and jump as soon as a target
    accepts all that t's run still accepts. What is left then simulates what was, so an agent
    loses nothing (Hahn et al., Good-for-MDPs Automata, TACAS 2020, section 3.3).
    """
    if not any(draft.jumps):
        return draft
    graph = [[t for t, _ in row] for row in draft.rows]
    waiting = waiting_states(draft)
    targets = {t for row in draft.jumps for t in row}
    entered = targets | {t for q in waiting for t in graph[q] if t not in waiting}
    pairs = [(t, u) for t in sorted(reachable(graph, targets)) for u in sorted(entered) if t != u]
    if len(pairs) > MAX_PAIRS:
        return draft
    inclusion = Inclusion(draft, diagrams, pairs)
    jumps = [list(row) for row in draft.jumps]
    following = _Following(draft, diagrams, inclusion, waiting)
    rank = components(graph)
    size = [len(reachable(graph, [t])) for t in range(len(graph))]
    candidates = [(q, t) for q, row in enumerate(draft.jumps) for t in row]
    for q, target in sorted(candidates, key=lambda jump: (-size[jump[1]], -rank[jump[1]], jump)):
        jumps[q].remove(target)
        if not following.follows(q, target, jumps):
            jumps[q].append(target)
            jumps[q].sort()
    return replace(draft, jumps=tuple(tuple(row) for row in jumps))


class _Following:
    """Whether waiting states can follow the runs of deterministic ones."""

    def __init__(
        self, draft: Draft, diagrams: Diagrams, inclusion: Inclusion, waiting: set[int]
    ) -> None:
        self._draft = draft
        self._diagrams = diagrams
        self._inclusion = inclusion
        self._waiting = waiting

    def follows(self, waiting: int, state: int, jumps: Sequence[Sequence[int]]) -> bool:
        """Whether `waiting`, with `jumps`, accepts what `state` accepts, letter by letter."""
        index = {(waiting, state): 0}
        work = [(waiting, state)]
        graph: list[list[tuple[int, bool]]] = []
        for q, t in work:
            edges: list[tuple[int, bool]] = []
            graph.append(edges)
            if any(self._covers(u, t) for u in jumps[q]):
                continue
            for (following, after), mark in self._steps(q, t):
                if following is None:
                    return False
                if following not in self._waiting:
                    if not self._covers(following, after):
                        return False
                    continue
                pair = (following, after)
                if pair not in index:
                    index[pair] = len(work)
                    work.append(pair)
                edges.append((index[pair], mark))
        component = components([[t for t, _ in edges] for edges in graph])
        return not any(
            mark and component[q] == component[t]
            for q, edges in enumerate(graph)
            for t, mark in edges
        )

    def _covers(self, right: int, left: int) -> bool:
        return left == right or self._inclusion.holds(left, right)

    def _steps(self, q: int, t: int) -> list[tuple[tuple[int | None, int], bool]]:
        steps: list[tuple[tuple[int | None, int], bool]] = []
        for (after, mark), letters in self._draft.rows[t].items():
            self._diagrams.budget.tick()
            missing = letters
            for (following, _), guard in self._draft.rows[q].items():
                if self._diagrams.conj(letters, guard) != FALSE:
                    steps.append(((following, after), mark))
                    missing = self._diagrams.minus(missing, guard)
            if missing != FALSE:
                steps.append(((None, after), mark))
        return steps
