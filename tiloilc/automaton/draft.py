"""Automata in the making: edge acceptance, diagrams as guards, no sink yet.

A missing letter leads to the sink. Every pass is a function Draft → Draft.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from tiloilc.automaton.bdd import Node

Row = dict[tuple[int, bool], Node]
"""The edges of a state: letters by (target, whether the edge accepts)."""


@dataclass(frozen=True, slots=True)
class Draft:
    """States 0, 1, 2, …; `jumps[q]` are the targets of the ε-jumps of q. `names` go along;
    None is that of a state which does nothing but stay, and has its letters for a name.

    `steps[q]` is the step of a written chain, `G F (a & X F b)`, that q stands for, if any; states
    of different steps stay apart although their languages agree. Empty: the order is free.
    """

    rows: tuple[Row, ...]
    jumps: tuple[tuple[int, ...], ...]
    initial: int
    names: tuple[Callable[[], str] | None, ...]
    steps: tuple[Hashable, ...] = ()

    def targets(self, state: int) -> list[int]:
        """Where edges and jumps of `state` lead, each once."""
        return list(dict.fromkeys([*(q for q, _ in self.rows[state]), *self.jumps[state]]))


def components(graph: Sequence[Sequence[int]]) -> list[int]:
    """The strongly connected component of each node; edges never lead to a greater number.

    Tarjan (1972), without recursion.
    """
    number = [0] * len(graph)
    low = [0] * len(graph)
    component = [-1] * len(graph)
    stack: list[int] = []
    count = met = 0
    for root in range(len(graph)):
        if number[root]:
            continue
        met += 1
        number[root] = low[root] = met
        stack.append(root)
        work = [(root, iter(graph[root]))]
        while work:
            node, successors = work[-1]
            least = low[node]
            for target in successors:
                if not number[target]:
                    met += 1
                    number[target] = low[target] = met
                    stack.append(target)
                    work.append((target, iter(graph[target])))
                    break
                if component[target] < 0 and number[target] < least:
                    least = number[target]
            else:
                work.pop()
                if work and least < low[work[-1][0]]:
                    low[work[-1][0]] = least
                if least == number[node]:
                    while component[node] < 0:
                        component[stack.pop()] = count
                    count += 1
            low[node] = least
    return component


def reachable(
    graph: Sequence[Sequence[int]] | Mapping[int, Sequence[int]], starts: Iterable[int]
) -> set[int]:
    """The nodes that can be reached from `starts`, these included."""
    found = set(starts)
    work = list(found)
    while work:
        for target in graph[work.pop()]:
            if target not in found:
                found.add(target)
                work.append(target)
    return found


def reversed_graph(graph: Sequence[Sequence[int]]) -> list[list[int]]:
    """The graph with all edges turned round."""
    back: list[list[int]] = [[] for _ in graph]
    for source, targets in enumerate(graph):
        for target in targets:
            back[target].append(source)
    return back


def on_cycles(draft: Draft) -> tuple[list[int], list[bool]]:
    """The component of each state, and whether it has a cycle through that state."""
    component = components([draft.targets(q) for q in range(len(draft.rows))])
    sizes: dict[int, int] = {}
    for number in component:
        sizes[number] = sizes.get(number, 0) + 1
    looping = [
        sizes[component[q]] > 1 or any(t == q for t, _ in row) for q, row in enumerate(draft.rows)
    ]
    return component, looping


def keep(draft: Draft, kept: set[int]) -> Draft:
    """Only the states `kept`, renumbered in their order; what led elsewhere leads to the sink."""
    new = {q: i for i, q in enumerate(sorted(kept))}
    return replace(
        draft,
        rows=tuple(
            {(new[t], mark): guard for (t, mark), guard in draft.rows[q].items() if t in kept}
            for q in new
        ),
        jumps=tuple(tuple(new[t] for t in draft.jumps[q] if t in kept) for q in new),
        initial=new[draft.initial],
        names=tuple(draft.names[q] for q in new),
        steps=tuple(draft.steps[q] for q in new if draft.steps),
    )


def with_copies(draft: Draft, states: Sequence[int], rows: Sequence[Row]) -> Draft:
    """`draft` with copies of `states` behind it, which have the edges `rows` and no jumps."""
    return replace(
        draft,
        rows=(*draft.rows, *rows),
        jumps=(*draft.jumps, *((),) * len(states)),
        names=(*draft.names, *(draft.names[q] for q in states)),
        steps=(*draft.steps, *(draft.steps[q] for q in states if draft.steps)),
    )
