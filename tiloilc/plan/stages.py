"""How far towards acceptance each automaton state is, and who is compared with whom.

Paper, section 3.2. Everything is about live states: the sink is no stage. An edge b → b' stands for
"in b the agent can read a letter and be in b'": by δ, or by an ε-jump and the target's edge on the
same letter, which is one edge because a jump costs no step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tiloilc.automaton.ldba import Ldba, StateId
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.plan.longest import Graph, directed_graph, longest_paths
from tiloilc.plan.model import Stages

__all__ = [
    "Stages",
    "ambiguous_stages",
    "is_absorbing",
    "max_stage",
    "stage_findings",
    "stage_graph",
    "stage_plan",
]


def stage_graph(ldba: Ldba) -> Graph:
    """The live successors of each state in ascending order; the sink has none."""
    follow = []
    for b in ldba.states:
        readers = () if b == ldba.sink else (b, *ldba.jump_targets[b])
        reached = {edge.target for reader in readers for edge in ldba.outgoing[reader]}
        follow.append(tuple(sorted(reached - {ldba.sink} if ldba.sink is not None else reached)))
    return tuple(follow)


def stage_plan(ldba: Ldba, span: Span | None = None) -> Stages:
    """Order the states of `ldba` and name the buffers of each discriminator (Eq. 6 to 8).

    SIDX(b) is the length of the longest acyclic path to b that meets no accepting state on the
    way, from where segments begin: the automaton's start (also if that accepts), or an accepting
    state if b is reached from no other. N(b) is the length of the longest such path that goes on
    from b to an accepting state. Where none goes through b without crossing itself, N(b) is
    SIDX(b) plus the distance to acceptance. Never-entered states have SIDX 0, and N is at least 1.

    Raises CompileError PLAN402, at `span`, if no accepting state can be reached.
    """
    follow = stage_graph(ldba)
    distance = _distances(follow, ldba.accepting)
    if distance[ldba.initial] < 0:
        raise CompileError(Diagnostic.of("PLAN402", span))
    index, length = _order(follow, ldba, distance)
    positive, negative = _buffers(follow, ldba, distance)
    return Stages(index, length, distance, positive, negative)


def max_stage(stages: Stages, states: Sequence[StateId] | NDArray[np.int64]) -> tuple[int, int]:
    """The buffer of one segment and how many of its states go there (Eq. 7, made total).

    `states` are the automaton states visited. A segment that ends in the sink is B_⊥'s, whole:
    the fatal state must be among the negatives. Any other is that of the visited state nearest to
    acceptance (an accepting one if there is one), ties to the larger SIDX, then to the one visited
    last; it is trimmed after the last step there, because what came later regressed.
    """
    visited = np.asarray(states, dtype=np.int64)
    assert len(visited), "a segment has a state"
    distance = np.asarray(stages.distance)
    if distance[visited[-1]] < 0:
        return stages.sink_buffer, len(visited)
    live = visited[distance[visited] >= 0]
    rank = [(int(distance[b]), -stages.index[b]) for b in live.tolist()]
    best = min(rank)
    last = max(i for i, b in enumerate(visited.tolist()) if _rank(stages, b) == best)
    return int(visited[last]), last + 1


def is_absorbing(ldba: Ldba) -> bool:
    """Whether accepting states lead to accepting states and the sink only (then visits dwell)."""
    follow = stage_graph(ldba)
    return all(set(follow[b]) <= ldba.accepting for b in ldba.accepting)


def ambiguous_stages(ldba: Ldba, stages: Stages) -> tuple[tuple[StateId, ...], ...]:
    """Groups of states at one distance of which Eq. 7 can name several for one segment.

    Two states are in such a group if a segment can visit both. Each can reach acceptance without
    the other: a shortest way meets no second state at the same distance.
    """
    reach = _ways(stage_graph(ldba), ldba.accepting)
    groups: dict[int, set[StateId]] = {}
    stage_states = [b for b in ldba.states if stages.distance[b] > 0]
    for i, b in enumerate(stage_states):
        for c in stage_states[i + 1 :]:
            meet = c in reach[b] or b in reach[c]
            if stages.distance[b] == stages.distance[c] and meet:
                groups.setdefault(stages.distance[b], set()).update((b, c))
    return tuple(tuple(sorted(groups[d])) for d in sorted(groups))


def stage_findings(ldba: Ldba, stages: Stages, span: Span | None = None) -> list[Diagnostic]:
    """What to know about the stages of `ldba`: PLAN403, PLAN405 and PLAN406, at `span`."""
    found = []
    for group in ambiguous_stages(ldba, stages):
        furthest = max(group, key=lambda b: stages.index[b])
        tied = [b for b in group if stages.index[b] == stages.index[furthest]]
        rule = "the one visited last counts" if len(tied) > 1 else f"state {furthest} counts"
        names = ", ".join(map(str, group[:-1])) + f" and {group[-1]}"
        found.append(Diagnostic.of("PLAN403", span, states=names, tie_break=rule))
    if is_absorbing(ldba):
        found.append(Diagnostic.of("PLAN405", span))
    if not _paths(stage_graph(ldba), ldba)[2]:
        found.append(Diagnostic.of("PLAN406", span, states=len(ldba.states)))
    return found


def _rank(stages: Stages, b: StateId) -> tuple[int, int] | None:
    return (stages.distance[b], -stages.index[b]) if stages.distance[b] >= 0 else None


def _distances(follow: Graph, accepting: frozenset[StateId]) -> tuple[int, ...]:
    """Edges to the nearest accepting state; -1 where none can be reached."""
    import networkx as nx

    if not accepting:
        return (-1,) * len(follow)
    backward = directed_graph(follow).reverse()
    distance = nx.multi_source_dijkstra_path_length(backward, accepting)
    return tuple(int(distance.get(b, -1)) for b in range(len(follow)))


def _paths(
    follow: Graph, ldba: Ldba
) -> tuple[Mapping[StateId, int], Mapping[StateId, int | None], bool]:
    """SIDX and N of the states that can be entered, and whether both are exact."""
    start = ldba.initial
    first = dict.fromkeys(follow[start], 1) if start in ldba.accepting else {start: 0}
    index, length, exact = longest_paths(follow, ldba.accepting, first)
    later = {b: 1 for f in sorted(ldba.accepting) for b in follow[f]}
    index_later, length_later, exact_later = longest_paths(follow, ldba.accepting, later)
    index, length = {**index_later, **index}, {**length_later, **length}
    if start in ldba.accepting:
        index[start] = 0
    return index, length, exact and exact_later


def _order(
    follow: Graph, ldba: Ldba, distance: Sequence[int]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    index, length, _ = _paths(follow, ldba)
    stages = tuple(index.get(b, 0) for b in ldba.states)
    direct = [stages[b] + max(distance[b], 0) for b in ldba.states]
    return stages, tuple(max(1, length.get(b) or 0, direct[b]) for b in ldba.states)


def _ways(follow: Graph, accepting: frozenset[StateId]) -> list[set[StateId]]:
    """`b ⇝ c` (Eq. 6) as the set of all c for each b; never reflexive."""
    import networkx as nx

    graph = directed_graph(follow, accepting)
    return [nx.descendants(graph, b) for b in range(len(follow))]


def _buffers(
    follow: Graph, ldba: Ldba, distance: Sequence[int]
) -> tuple[tuple[tuple[int, ...], ...], tuple[tuple[int, ...], ...]]:
    """For each discriminator its positive buffers (b ⇝ c ⇝* b_f) and its negative (c ⇝* b, B_⊥).

    A cycle without acceptance puts c on both sides: it is positive iff strictly nearer to B*.
    """
    ways = _ways(follow, ldba.accepting)
    positive: list[tuple[int, ...]] = []
    negative: list[tuple[int, ...]] = []
    for b in ldba.states:
        if distance[b] <= 0:
            positive.append(())
            negative.append(())
            continue
        ahead = {c for c in ways[b] if distance[c] >= 0}
        behind = {c for c in ldba.states if b in ways[c]} | {b}
        nearer = {c for c in ahead if distance[c] < distance[b]}
        better = (ahead - behind) | (ahead & behind & nearer)
        positive.append(tuple(sorted(better)))
        negative.append((*sorted(behind - better), len(ldba.names)))
    return tuple(positive), tuple(negative)
