"""Longest acyclic paths, exactly where that can be paid: component by component."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Graph = tuple[tuple[int, ...], ...]
"""The successors of each node, in ascending order."""

MAX_STEPS = 2_000_000
"""Path nodes visited in one component's exponential search (0.3 s): pays for any of eight nodes."""


@dataclass
class _Component:
    """The simple paths inside one strongly connected component.

    `through[x, y][b]` is the greatest length, in edges, of one from x by b to y.
    """

    nodes: tuple[int, ...]
    through: dict[tuple[int, int], dict[int, int]] = field(default_factory=dict)
    exact: bool = True

    def within(self, x: int, y: int) -> int | None:
        """The length of the longest simple path from x to y, None if there is none."""
        return self.through.get((x, y), {}).get(y)


def longest_paths(
    follow: Graph, ends: frozenset[int], entries: Mapping[int, int]
) -> tuple[dict[int, int], dict[int, int | None], bool]:
    """Longest acyclic paths that stop at the first node of `ends`.

    Paths begin at the nodes of `entries`, which says how many edges count as gone by then. Gives,
    for each node reached: the length to it; the length by it to a node of `ends`, None if no
    acyclic path does that; and whether all lengths are exact. A simple path meets the components
    in their order and never returns, so the exponential search stays inside each; a component on
    which it exceeds MAX_STEPS counts as one node.
    """
    enter: dict[int, int] = dict(entries)
    index: dict[int, int] = {b: n for b, n in entries.items() if b in ends}
    searched: list[_Component] = []
    for nodes in _components(follow, ends, sorted(entries)):
        component = _search(follow, nodes, [x for x in nodes if x in enter])
        searched.append(component)
        for (x, y), through in component.through.items():
            index[y] = max(index.get(y, 0), enter[x] + through[y])
        for y in nodes:
            for z in follow[y]:
                if y in index and z not in nodes:
                    enter[z] = max(enter.get(z, 0), index[y] + 1)
                    if z in ends:
                        index[z] = enter[z]
    leave = _ways_out(follow, ends, searched)
    length: dict[int, int | None] = {b: index[b] if b in ends else None for b in sorted(index)}
    for component in searched:
        for (x, y), through in component.through.items():
            for b, edges in through.items():
                if y in leave:
                    length[b] = max(length[b] or 0, enter[x] + edges + leave[y])
    return index, length, all(component.exact for component in searched)


def _components(follow: Graph, ends: frozenset[int], starts: list[int]) -> list[tuple[int, ...]]:
    """The strongly connected components reachable from `starts`, `ends` left out, in order."""
    reach: dict[int, frozenset[int]] = {}
    waiting = [b for b in starts if b not in ends]
    while waiting:
        b = waiting.pop()
        if b not in reach:
            reach[b] = _reach(follow, ends, b)
            waiting.extend(reach[b])
    groups = {tuple(sorted(c for c in reach[b] if b in reach[c])) for b in sorted(reach)}
    return sorted(groups, key=lambda nodes: (-len(reach[nodes[0]]), nodes))


def _reach(follow: Graph, ends: frozenset[int], start: int) -> frozenset[int]:
    seen, waiting = {start}, [start]
    while waiting:
        new = [c for c in follow[waiting.pop()] if c not in seen and c not in ends]
        seen.update(new)
        waiting.extend(new)
    return frozenset(seen)


def _search(follow: Graph, nodes: tuple[int, ...], entries: list[int]) -> _Component:
    """All simple paths inside `nodes` from each of `entries`, by depth-first search."""
    component = _Component(nodes)
    inside = set(nodes)
    steps = 0
    for x in entries:
        path, trail = [x], [iter(follow[x])]
        on_path = {x}
        _note(component, path)
        while trail:
            steps += len(path)
            if steps > MAX_STEPS:
                flat = dict.fromkeys(nodes, 0)
                return _Component(nodes, {(a, y): flat for a in entries for y in nodes}, False)
            step = next(trail[-1], None)
            if step is None:
                trail.pop()
                on_path.discard(path.pop())
            elif step in inside and step not in on_path:
                path.append(step)
                on_path.add(step)
                trail.append(iter(follow[step]))
                _note(component, path)
    return component


def _note(component: _Component, path: list[int]) -> None:
    through = component.through.setdefault((path[0], path[-1]), {})
    for b in path:
        through[b] = max(through.get(b, 0), len(path) - 1)


def _ways_out(follow: Graph, ends: frozenset[int], components: list[_Component]) -> dict[int, int]:
    """For nodes with an edge out of their component: the longest way by such an edge to an end."""
    leave: dict[int, int] = {}
    onward: dict[int, int] = {}
    for component in reversed(components):
        for y in component.nodes:
            lengths = [1 for z in follow[y] if z in ends]
            lengths += [1 + onward[z] for z in follow[y] if z in onward]
            if lengths:
                leave[y] = max(lengths)
        entered: dict[int, int] = {}
        for x, y in component.through:
            if y in leave:
                within = component.within(x, y)
                assert within is not None
                entered[x] = max(entered.get(x, 0), within + leave[y])
        onward.update(entered)
    return leave
