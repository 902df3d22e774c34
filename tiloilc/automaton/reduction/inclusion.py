"""Which states accept no more than which others."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft, components, reachable, reversed_graph
from tiloilc.automaton.reduction.letters import moves

MAX_PAIRS = 4_000
"""Pairs of states to compare by language: beyond, inclusion costs more than it saves."""

DEAD = -1
"""No state: from here on nothing is accepted."""


class Inclusion:
    """Which pairs (left, right) have L(left) ⊆ L(right); right ones must be deterministic.

    `left` goes with its jumps. A word that is accepted on the left and not on the right leads, in
    the product, to a cycle that is marked on the left only, or to a dead right side.
    """

    def __init__(self, draft: Draft, diagrams: Diagrams, pairs: Sequence[tuple[int, int]]) -> None:
        self._budget = diagrams.budget
        self._jumps = draft.jumps
        found = moves(draft, diagrams)
        self._moves = found or []
        self._index: dict[tuple[int, int], int] = {}
        self.complete = found is not None
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
            if len(work) > MAX_PAIRS or not self.complete:
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
        edges = []
        for state in (left, *self._jumps[left]):
            for target, mark, letters in self._moves[state]:
                self._budget.tick()
                missing = letters
                for other, other_mark, others in self._moves[right]:
                    if letters & others:
                        edges.append(((target, other), mark, other_mark))
                        missing &= ~others
                if missing:
                    edges.append(((target, DEAD), mark, False))
        return edges

    def holds(self, left: int, right: int) -> bool:
        """Whether L(left) ⊆ L(right); False also where it was too much to find out."""
        return self.complete and self._index[left, right] not in self._bad
