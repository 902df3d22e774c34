"""Drop the jumps that an agent need not take, because it can wait for others.

Good-for-MDPs automata may lose what another automaton can do without (Hahn, Perez, Schewe, Somenzi,
Trivedi and Wojtczak, Good-for-MDPs Automata for Probabilistic Analysis and Reinforcement Learning,
TACAS 2020, section 3.3). Here an agent that would jump from q to t waits instead and keeps t's run
in mind. Almost surely its world, under an optimal finite-memory strategy, ends in a recurrent part,
where the waiting state and t's run take the edges C of a strongly connected piece of their product,
all of them again and again, and no others. If for every such C with a mark of t some pair of states
in it has a jump whose target accepts every word of C that t's run accepts, nothing is lost: the
agent takes that jump when it has come to C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft, components, on_cycles, reachable
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion
from tiloilc.automaton.reduction.jumps import waiting_states
from tiloilc.automaton.reduction.letters import moves


def drop_jumps(draft: Draft, diagrams: Diagrams) -> Draft:
    """Drop jumps one after the other: those into the most states first, the built ones last."""
    if not any(draft.jumps):
        return draft
    following = Following.of(draft, diagrams)
    if following is None:
        return draft
    graph = [[t for t, _ in row] for row in draft.rows]
    rank = components(graph)
    size = [len(reachable(graph, [t])) for t in range(len(graph))]
    jumps = following.jumps
    _add_jumps(following, draft)

    def order(jump: tuple[int, int]) -> tuple[int, bool, int, int, int]:
        q, target = jump
        return -size[target], target in draft.jumps[q], rank[target], -q, -target

    for q, target in sorted(((q, t) for q, row in enumerate(jumps) for t in row), key=order):
        jumps[q].remove(target)
        if not following.follows(q, target):
            jumps[q].append(target)
            jumps[q].sort()
    return replace(draft, jumps=tuple(tuple(row) for row in jumps))


def _add_jumps(following: Following, draft: Draft) -> None:
    """Add the jumps between states on cycles that change nothing, so that others can go."""
    _, looping = on_cycles(draft)
    for q in sorted(following.waiting):
        if looping[q]:
            own = following.jumps[q]
            more = [t for t in following.ahead if looping[t] and t not in own]
            following.jumps[q] = sorted([*own, *(t for t in more if following.follows(q, t))])


def can_wait(draft: Draft, diagrams: Diagrams) -> bool:
    """Whether an agent that misses a jump loses nothing, for there are others to come.

    If so, an automaton whose waiting states are deterministic is good for MDPs. Also true where it
    would take too long to find out.
    """
    following = Following.of(draft, diagrams)
    return following is None or all(
        following.follows(q, t, missed=True) for q, row in enumerate(draft.jumps) for t in row
    )


class _Edge(NamedTuple):
    """An edge between pairs (a waiting state, a state whose run is kept in mind)."""

    target: int
    mark: bool
    letters: int


class Following:
    """Whether waiting states can follow the runs of deterministic ones. `jumps` may change."""

    def __init__(
        self,
        draft: Draft,
        diagrams: Diagrams,
        inclusion: Inclusion,
        waiting: set[int],
        ahead: list[int],
    ) -> None:
        self.jumps = [list(row) for row in draft.jumps]
        self.waiting = waiting
        self.ahead = ahead
        self._moves = moves(draft, diagrams) or []
        self._budget = diagrams.budget
        self._inclusion = inclusion

    @classmethod
    def of(cls, draft: Draft, diagrams: Diagrams) -> Following | None:
        """For `draft`; None if it has no jumps, or too much to compare."""
        waiting = waiting_states(draft)
        ahead = [q for q in range(len(draft.rows)) if q not in waiting]
        pairs = [(t, u) for t in ahead for u in ahead if t != u]
        if not waiting or len(pairs) > MAX_PAIRS:
            return None
        inclusion = Inclusion(draft, diagrams, pairs)
        return cls(draft, diagrams, inclusion, waiting, ahead) if inclusion.complete else None

    def follows(self, waiting: int, state: int, missed: bool = False) -> bool:
        """Whether an agent in `waiting` gets all that it would get in `state`.

        `missed`: it reads a letter before it may jump.
        """
        pairs = [(waiting, state)]
        index = {} if missed else {(waiting, state): 0}
        graph: list[list[_Edge]] = []
        for q, t in pairs:
            edges: list[_Edge] = []
            graph.append(edges)
            waits = missed and len(graph) == 1
            if not waits and any(self._covers(u, t) for u in self.jumps[q]):
                continue
            for following, after, mark, letters in self._steps(q, t):
                if following is None:
                    return False
                if following not in self.waiting:
                    if not self._covers(following, after):
                        return False
                    continue
                pair = (following, after)
                if pair not in index:
                    index[pair] = len(pairs)
                    pairs.append(pair)
                edges.append(_Edge(index[pair], mark, letters))
        return self._finds_jumps(pairs, graph)

    def _covers(self, right: int, left: int) -> bool:
        return left == right or self._inclusion.holds(left, right)

    def _steps(self, q: int, t: int) -> list[tuple[int | None, int, bool, int]]:
        steps: list[tuple[int | None, int, bool, int]] = []
        for after, mark, letters in self._moves[t]:
            self._budget.tick()
            missing = letters
            for following, _, others in self._moves[q]:
                if letters & others:
                    steps.append((following, after, mark, letters & others))
                    missing &= ~others
            if missing:
                steps.append((None, after, mark, missing))
        return steps

    def _finds_jumps(self, pairs: Sequence[tuple[int, int]], graph: list[list[_Edge]]) -> bool:
        """Whether every strongly connected piece with a mark has a pair with a jump to take."""
        work = [set(range(len(pairs)))]
        while work:
            for piece in _marked_pieces(graph, work.pop()):
                good = {
                    n
                    for n in piece
                    if any(
                        self._accepts_inside(graph, piece, n, u) for u in self.jumps[pairs[n][0]]
                    )
                }
                if not good:
                    return False
                work.append(piece - good)
        return True

    def _accepts_inside(self, graph: list[list[_Edge]], piece: set[int], n: int, u: int) -> bool:
        """Whether `u` accepts what the marks on the edges of `piece`, taken from `n` on, accept."""
        index = {(n, u): 0}
        work = [(n, u)]
        product: list[list[tuple[int, bool, bool]]] = []
        for m, v in work:
            edges = []
            for edge in graph[m]:
                if edge.target not in piece:
                    continue
                self._budget.tick()
                missing = edge.letters
                for after, mark, letters in self._moves[v]:
                    if not edge.letters & letters:
                        continue
                    missing &= ~letters
                    pair = (edge.target, after)
                    if pair not in index:
                        index[pair] = len(work)
                        work.append(pair)
                    edges.append((index[pair], edge.mark, mark))
                if missing:
                    return False
            product.append(edges)
        quiet = components([[t for t, _, mark in edges if not mark] for edges in product])
        return not any(
            left and not right and quiet[q] == quiet[t]
            for q, edges in enumerate(product)
            for t, left, right in edges
        )


def _marked_pieces(graph: list[list[_Edge]], kept: set[int]) -> list[set[int]]:
    """The strongly connected pieces of `graph` on the nodes `kept` with a marked edge inside."""
    component = components(
        [
            [e.target for e in edges if e.target in kept] if n in kept else []
            for n, edges in enumerate(graph)
        ]
    )
    marked = {
        component[n]
        for n in kept
        for e in graph[n]
        if e.mark and e.target in kept and component[n] == component[e.target]
    }
    return [{n for n in kept if component[n] == c} for c in sorted(marked)]
