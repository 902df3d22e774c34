"""Hand-made automata and labels, independent of the translator and the predicate language."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tiloilc.automaton.ldba import Cube, Edge, Ldba

ALWAYS = Cube(0, 0)


def chain(visits: str, *, cyclic: bool, avoid: str = "") -> Ldba:
    """State i waits for the i-th of `visits`, the state after the last accepts.

    `F (a & X F b)` or, cyclic, `G F (a & X F b)`; with `& G !z` for `avoid="z"`.
    """
    names = visits + avoid
    bad = 1 << len(visits) if avoid else 0
    last, sink = len(visits), len(visits) + 1
    edges = []
    for i in range(last):
        edges.append(Edge(i, i + 1, (Cube(1 << i | bad, 1 << i),)))
        edges.append(Edge(i, i, (Cube(1 << i | bad, 0),)))
    if cyclic:
        edges.append(Edge(last, 1, (Cube(1 | bad, 1),)))
        edges.append(Edge(last, 0, (Cube(1 | bad, 0),)))
    else:
        edges.append(Edge(last, last, (Cube(bad, 0),)))
    if avoid:
        edges += [Edge(b, sink, (Cube(bad, bad),)) for b in range(last + 1)]
        edges.append(Edge(sink, sink, (ALWAYS,)))
    states = last + 1 + bool(avoid)
    return Ldba(
        tuple(names),
        tuple(f"state {b}" for b in range(states)),
        frozenset({last}),
        sink if avoid else None,
        tuple(sorted(edges)),
    )


def staying(goal: str = "y", avoid: str = "b") -> Ldba:
    """`F G y & G !b`: one jumps when one will stay."""
    edges = (
        Edge(0, 0, (Cube(2, 0),)),
        Edge(0, 2, (Cube(2, 2),)),
        Edge(1, 1, (Cube(3, 1),)),
        Edge(1, 2, (Cube(1, 0), Cube(3, 3))),
        Edge(2, 2, (ALWAYS,)),
    )
    names = ("not yet", "staying", "sink")
    return Ldba((goal, avoid), names, frozenset({1}), 2, edges, ((0, 1),))


def bits(*tests: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    """Letters from one test a proposition."""

    def labels(observations: np.ndarray) -> np.ndarray:
        letters = np.zeros(len(observations), np.int64)
        for i, test in enumerate(tests):
            letters |= np.asarray(test(observations), np.int64) << i
        return letters

    return labels


def disc(x: float, y: float, radius: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda o: np.hypot(o[:, 0].astype(float) - x, o[:, 1].astype(float) - y) < radius


def cells(x0: int, y0: int, x1: int, y1: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda o: (o[:, 0] >= x0) & (o[:, 0] <= x1) & (o[:, 1] >= y0) & (o[:, 1] <= y1)


RED, GREEN = disc(0.45, -0.75, 0.3), disc(0.45, 1.0, 0.3)
YELLOW, BLUE = disc(-0.85, 0.15, 0.3), disc(0.0, 0.0, 0.8)

CORES = {"a": (15, 8, 19, 12), "b": (8, 15, 12, 19), "c": (1, 8, 5, 12), "d": (8, 1, 12, 5)}
CENTRE = cells(7, 7, 13, 13)


def circular(zones: int) -> Callable[[np.ndarray], np.ndarray]:
    return bits(*(cells(*CORES[name]) for name in "abcd"[:zones]), CENTRE)


def sequential(zones: int) -> Callable[[np.ndarray], np.ndarray]:
    return bits(*(cells(7 * i, 0, 7 * i + 6, 6) for i in range(1, zones + 1)))


def corridor(distance: int) -> Callable[[np.ndarray], np.ndarray]:
    return bits(lambda o: (o[:, 0] >= distance) & (o[:, 1] == 0), lambda o: o[:, 1] != 0)
