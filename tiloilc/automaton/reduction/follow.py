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

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft, components, on_cycles, reachable, reversed_graph
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion
from tiloilc.automaton.reduction.jumps import waiting_states
from tiloilc.automaton.reduction.letters import moves


def drop_jumps(draft: Draft, diagrams: Diagrams) -> Draft:
    """Drop jumps one after the other: those into the most states first, the built ones last.

    Before, jumps are added that change nothing, so that others can go.
    """
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
    pairs = [
        (q, t)
        for q in sorted(following.waiting)
        for t in following.ahead
        if looping[q] and looping[t] and t not in following.jumps[q]
    ]
    for (q, t), changes_nothing in zip(pairs, following.followed(pairs), strict=True):
        if changes_nothing:
            following.jumps[q] = sorted([*following.jumps[q], t])


def can_wait(draft: Draft, diagrams: Diagrams) -> bool:
    """Whether an agent that misses a jump loses nothing, for there are others to come.

    If so, an automaton whose waiting states are deterministic is good for MDPs. Also true where it
    would take too long to find out.
    """
    following = Following.of(draft, diagrams)
    jumps = [(q, t) for q, row in enumerate(draft.jumps) for t in row]
    return following is None or all(following.followed(jumps, missed=True))


NOWHERE = -1
"""Where a state leads on letters that it has no edge for."""


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
        self._common: dict[tuple[int, int], list[tuple[int, int, bool, int]]] = {}

    @classmethod
    def of(
        cls,
        draft: Draft,
        diagrams: Diagrams,
        followed: Collection[int] | None = None,
        taken: Collection[int] | None = None,
    ) -> Following | None:
        """For `draft`; None if it has no jumps, or too much to compare.

        Of the deterministic states, only runs of `followed` can be asked for, and only `taken` be
        reached by jumps and otherwise, if given.
        """
        waiting = waiting_states(draft)
        ahead = [q for q in range(len(draft.rows)) if q not in waiting]
        left = [t for t in ahead if followed is None or t in followed]
        right = [u for u in ahead if taken is None or u in taken]
        pairs = [(t, u) for t in left for u in right if t != u]
        if not waiting or len(pairs) > MAX_PAIRS:
            return None
        inclusion = Inclusion(draft, diagrams, pairs)
        return cls(draft, diagrams, inclusion, waiting, ahead) if inclusion.complete else None

    def follows(self, waiting: int, state: int) -> bool:
        """Whether an agent in `waiting` gets all that it would get in `state`."""
        return all(self.followed([(waiting, state)]))

    def followed(self, pairs: Sequence[tuple[int, int]], missed: bool = False) -> list[bool]:
        """Whether an agent in `waiting` gets all that it would get in `state`, for each pair.

        `missed`: it reads a letter before it may jump.
        """
        nodes = list(pairs)
        index = {} if missed else {pair: n for n, pair in enumerate(nodes)}
        graph: list[list[_Edge]] = []
        lost: set[int] = set()
        for n, (q, t) in enumerate(nodes):
            edges: list[_Edge] = []
            graph.append(edges)
            waits = missed and n < len(pairs)
            if not waits and any(self._covers(u, t) for u in self.jumps[q]):
                continue
            for following, after, mark, letters in self._steps(q, t):
                if following in self.waiting:
                    pair = (following, after)
                    if pair not in index:
                        index[pair] = len(nodes)
                        nodes.append(pair)
                    edges.append(_Edge(index[pair], mark, letters))
                elif following == NOWHERE or not self._covers(following, after):
                    lost.add(n)
        for piece in _marked_pieces(graph, range(len(nodes))):
            if not self._has_jumps(nodes, graph, piece):
                lost |= piece
        lost = reachable(reversed_graph([[e.target for e in edges] for edges in graph]), lost)
        return [n not in lost for n in range(len(pairs))]

    def _covers(self, right: int, left: int) -> bool:
        return left == right or self._inclusion.holds(left, right)

    def _steps(self, q: int, t: int) -> list[tuple[int, int, bool, int]]:
        """Where q and t lead on the same letters, whether t accepts there, and the letters."""
        steps = self._common.get((q, t))
        if steps is None:
            steps = self._common[q, t] = []
            for after, mark, letters in self._moves[t]:
                self._budget.tick()
                missing = letters
                for following, _, others in self._moves[q]:
                    if letters & others:
                        steps.append((following, after, mark, letters & others))
                        missing &= ~others
                if missing:
                    steps.append((NOWHERE, after, mark, missing))
        return steps

    def _has_jumps(
        self, nodes: Sequence[tuple[int, int]], graph: list[list[_Edge]], piece: set[int]
    ) -> bool:
        """Whether every strongly connected part of `piece` with a mark has a jump to take.

        Some jump at a node does for all parts with that node, but for those that stay where its
        run finds no marks; these need another one.
        """
        work = [piece]
        while work:
            part = work.pop()
            best: tuple[int, set[int], list[set[int]]] | None = None
            good = set()
            for n in sorted(part):
                for u in self.jumps[nodes[n][0]]:
                    missed = self._missed_inside(graph, part, n, u)
                    if missed is None or any(len(place) == len(part) for place in missed):
                        continue
                    size = sum(map(len, missed))
                    if not missed:
                        good.add(n)
                        break
                    if best is None or size < best[0]:
                        best = size, {n}, missed
            if good:
                best = 0, good, []
            if best is None:
                return False
            for nodes_left in (part - best[1], *best[2]):
                work += _marked_pieces(graph, nodes_left)
        return True

    def _missed_inside(
        self, graph: list[list[_Edge]], piece: set[int], n: int, u: int
    ) -> list[set[int]] | None:
        """Where in `piece`, taken from `n` on, marks on the edges come without marks of `u`.

        The nodes of each such place; None if a letter ends the run of u.
        """
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
                    return None
            product.append(edges)
        alone = [
            (q, t) for q, edges in enumerate(product) for t, left, right in edges if left > right
        ]
        if not alone:
            return []
        quiet = components([[t for t, _, mark in edges if not mark] for edges in product])
        missed = {quiet[q] for q, t in alone if quiet[q] == quiet[t]}
        return [{work[q][0] for q, c in enumerate(quiet) if c == place} for place in sorted(missed)]


def _marked_pieces(graph: list[list[_Edge]], kept: Collection[int]) -> list[set[int]]:
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
