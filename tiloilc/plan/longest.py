"""Longest acyclic paths, exactly where that can be paid: component by component."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import networkx as nx

Graph: TypeAlias = tuple[tuple[int, ...], ...]
"""The successors of each node, in ascending order."""

Through: TypeAlias = dict[tuple[int, int], dict[int, int]]
"""`through[x, y][b]` is the length, in edges, of the longest simple path from x by b to y."""

MAX_STEPS = 2_000_000
"""Path nodes in one component's exponential search (0.4 s): pays for any of eight nodes that is
entered at two.
"""

START, END = (-1, "start"), (-1, "end")


def directed_graph(follow: Graph, ends: Collection[int] = ()) -> nx.DiGraph[int]:
    """`follow` as a graph of networkx in which nothing leads on from `ends`."""
    import networkx as nx

    graph: nx.DiGraph[int] = nx.DiGraph()
    graph.add_nodes_from(range(len(follow)))
    graph.add_edges_from((b, c) for b, row in enumerate(follow) if b not in ends for c in row)
    return graph


def longest_paths(
    follow: Graph, ends: frozenset[int], entries: Mapping[int, int]
) -> tuple[dict[int, int], dict[int, int | None], bool]:
    """Longest acyclic paths that stop at the first node of `ends`.

    Paths begin at the nodes of `entries`, which says how many edges count as gone by then. Gives,
    for each node reached: the length to it; the length by it to a node of `ends`, None if no
    acyclic path does that; and whether all lengths are exact. A simple path meets the strongly
    connected components in their order and never returns, so the exponential search stays inside
    each, and the ways from component to component make an acyclic graph. A component on which the
    search exceeds MAX_STEPS counts as one node.
    """
    import networkx as nx

    graph = directed_graph(follow, ends)
    reached = sorted(set(entries).union(*(nx.descendants(graph, b) for b in entries)))
    graph = graph.subgraph(reached).copy()
    through: Through = {}
    exact = True
    ways: nx.DiGraph[tuple[int, str]] = nx.DiGraph()
    ways.add_nodes_from((START, END))
    ways.add_weighted_edges_from((START, (b, "in"), -entries[b]) for b in sorted(entries))
    ways.add_weighted_edges_from(((b, "out"), END, 0) for b in reached if b in ends)
    for nodes in nx.strongly_connected_components(graph):
        doors = [b for b in nodes if b in entries or not nodes.issuperset(graph.pred[b])]
        paths = _simple_paths(graph, nodes, doors)
        exact = exact and paths is not None
        flat = dict.fromkeys(nodes, 0)
        through |= {(x, y): flat for x in doors for y in nodes} if paths is None else paths
        out = [(b, c) for b in nodes for c in graph[b] if c not in nodes]
        ways.add_weighted_edges_from(((b, "out"), (c, "in"), -1) for b, c in out)
    for (x, y), lengths in through.items():
        ways.add_edge((x, "in"), (y, "out"), weight=-lengths[y])
    # The greatest length is the least weight; nothing is a cycle here, so weights may be negative.
    before = nx.single_source_bellman_ford_path_length(ways, START)
    after = nx.single_source_bellman_ford_path_length(ways.reverse(), END)
    length: dict[int, int | None] = dict.fromkeys(reached)
    for (x, y), lengths in through.items():
        if (y, "out") in after:
            outside = -int(before[x, "in"] + after[y, "out"])
            for b, inside in lengths.items():
                length[b] = max(length[b] or 0, outside + inside)
    return {b: -int(before[b, "out"]) for b in reached}, length, exact


def _simple_paths(graph: nx.DiGraph[int], nodes: set[int], doors: Iterable[int]) -> Through | None:
    """The simple paths inside `nodes` from each of `doors`; None if they are too many."""
    import networkx as nx

    component = graph.subgraph(nodes).copy()
    through: Through = {}
    steps = 0
    for x in doors:
        for path in chain([[x]], nx.all_simple_paths(component, x, nodes - {x})):
            steps += len(path) * (1 + graph.out_degree(path[-1]))
            if steps > MAX_STEPS:
                return None
            lengths = through.setdefault((x, path[-1]), {})
            for b in path:
                lengths[b] = max(lengths.get(b, 0), len(path) - 1)
    return through
