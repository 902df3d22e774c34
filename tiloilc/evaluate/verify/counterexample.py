"""The likeliest way in which a policy fails on a finite task, as a path that repeats its end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, dijkstra

from tiloilc.evaluate.verify.chain import Chain
from tiloilc.evaluate.verify.exact import formula_of
from tiloilc.evaluate.verify.told import Path
from tiloilc.ltl import Lasso, holds
from tiloilc.ltl.ast import Formula
from tiloilc.plan import Plan
from tiloilc.product import Int

if TYPE_CHECKING:
    from tiloilc.tasks import MarkovModel

Floats: TypeAlias = NDArray[np.float64]

A_STEP = 1e-9
"""Cost of a step beside that of chance: of ways that are as likely the shortest is shown."""

MOST_TRIED = 20
"""Ends that are looked at where the automaton's jumps leave open whether one is a failure."""


@dataclass(frozen=True, slots=True, eq=False)
class Failure:
    """A path into an end without acceptance, around in which it goes for ever.

    `probability` is that of its way into the sink or, if it stays out of it, into the end. `nodes`
    is the size of the end, all of which is visited again and again.
    """

    path: Path
    probability: float
    nodes: int


def failure(chain: Chain, model: MarkovModel, plan: Plan) -> Failure | None:
    """The likeliest way to fail; None if all bottom components accept.

    Where jumps may have been chosen badly, the formula is asked whether the path satisfies it.
    """
    component, bottom = chain.ends()
    accepts = np.zeros(len(bottom), np.bool_)
    accepts[component[chain.accepting]] = True
    ends = (bottom & ~accepts)[component]
    asked = formula_of(plan) if plan.ldba.jumps else None
    for way, probability in _ways(chain, ends, component, plan.ldba.sink):
        found = _failure(chain, model, component, ends, way, probability)
        if asked is None or not _satisfied(found.path, plan, asked):
            return found
    return None


def _ways(
    chain: Chain, ends: NDArray[np.bool_], component: Int, sink: int | None
) -> Iterator[tuple[list[int], float]]:
    """The likeliest way into the sink and to each other end, and its probability; likeliest first.

    `ends` [n] are the nodes of bottom components without acceptance.
    """
    n = len(chain.states)
    edges = chain.edges.tocoo()
    starts = np.flatnonzero(chain.initial > 0)
    rows = np.concatenate([edges.row, np.full(len(starts), n)])
    columns = np.concatenate([edges.col, starts])
    chances = np.concatenate([edges.data, chain.initial[starts]])
    distance, before = _distances(rows, columns, chances, n)
    fell = chain.automaton == (-1 if sink is None else sink)
    nearest: dict[int, int] = {}
    for node in sorted(np.flatnonzero(ends | fell).tolist(), key=lambda i: (distance[i], i)):
        nearest.setdefault(-1 if fell[node] else int(component[node]), node)
    for node in list(nearest.values())[:MOST_TRIED]:
        way = _back(before, node, n)[1:]
        yield way, float(np.exp(A_STEP * len(way) - distance[node]))


def _failure(
    chain: Chain,
    model: MarkovModel,
    component: Int,
    ends: NDArray[np.bool_],
    way: list[int],
    probability: float,
) -> Failure:
    """The way, on to its end, and around in there, through all of it where that is one cycle."""
    edges = chain.edges.tocoo()
    distance, before = _distances(edges.row, edges.col, edges.data, way[-1])
    end = min(np.flatnonzero(ends).tolist(), key=lambda i: (distance[i], i))
    way = [*way, *_back(before, end, way[-1])[1:]]
    inside = np.flatnonzero(component == component[end])
    loop = _cycle(csr_array(chain.edges[inside][:, inside]), int(np.searchsorted(inside, end)))
    nodes = np.array([*way, *inside[loop[1:]].tolist()])
    seen = model.seen[chain.states[nodes]]
    path = Path(seen, chain.letters[nodes], chain.automaton[nodes], len(way) - 1)
    return Failure(path, probability, len(inside))


def _distances(
    rows: NDArray[np.integer], columns: NDArray[np.integer], chances: Floats, source: int
) -> tuple[Floats, NDArray[np.integer]]:
    """How far each node is from `source`, in logarithms of chance, and the node before it."""
    n = int(max(rows.max(), columns.max())) + 1
    costs = A_STEP - np.log(np.minimum(chances, 1.0))
    graph = csr_array((costs, (rows, columns)), shape=(n, n))
    distance, before = dijkstra(graph, indices=np.array([source]), return_predecessors=True)
    return distance[0], before[0]


def _back(before: NDArray[np.integer], node: int, source: int) -> list[int]:
    """The way from `source` to `node`, both included."""
    way = [node]
    while way[-1] != source:
        way.append(int(before[way[-1]]))
    return way[::-1]


def _cycle(edges: csr_array, start: int) -> list[int]:
    """A shortest cycle from `start` in a strongly connected graph, the return left out."""
    order, before = breadth_first_order(edges, start, return_predecessors=True)
    back = set(edges[:, [start]].tocoo().row.tolist())
    last = next(int(node) for node in order.tolist() if node in back)
    cycle = [last]
    while cycle[-1] != start:
        cycle.append(int(before[cycle[-1]]))
    return cycle[::-1]


def _satisfied(path: Path, plan: Plan, formula: Formula) -> bool:
    letters = tuple(path.letters.tolist())
    assert path.loop is not None
    lasso = Lasso(letters[: path.loop], letters[path.loop :])
    return holds(formula, lasso, plan.ldba.propositions)
