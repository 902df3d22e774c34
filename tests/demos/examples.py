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


def around(*tours: str, avoid: str) -> Ldba:
    """`(G F (a & X F b) | G F …) & G !z`: one jumps into the tour that one will make for ever.

    Propositions are single characters, in the order in which they first occur.
    """
    names = "".join(dict.fromkeys("".join(tours) + avoid))
    bit = {name: 1 << i for i, name in enumerate(names)}
    bad = bit[avoid]
    starts = [1 + sum(len(t) + 1 for t in tours[:i]) for i in range(len(tours) + 1)]
    sink = starts[-1]
    edges = [Edge(0, 0, (Cube(bad, 0),)), Edge(0, sink, (Cube(bad, bad),))]
    for start, tour in zip(starts, tours, strict=False):
        last = start + len(tour)
        for b, name in enumerate(tour, start):
            edges.append(Edge(b, b + 1, (Cube(bit[name] | bad, bit[name]),)))
            edges.append(Edge(b, b, (Cube(bit[name] | bad, 0),)))
        first = bit[tour[0]]
        edges.append(Edge(last, start + 1, (Cube(first | bad, first),)))
        edges.append(Edge(last, start, (Cube(first | bad, 0),)))
        edges += [Edge(b, sink, (Cube(bad, bad),)) for b in range(start, last + 1)]
    edges.append(Edge(sink, sink, (ALWAYS,)))
    accepting = frozenset(s + len(t) for s, t in zip(starts, tours, strict=False))
    states = tuple(f"state {b}" for b in range(sink + 1))
    jumps = tuple((0, start) for start in starts[:-1])
    return Ldba(tuple(names), states, accepting, sink, tuple(sorted(edges)), jumps)


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


def heading(observations: np.ndarray) -> np.ndarray:
    """Where Carlo's cars look, in radians."""
    if observations.shape[1] == 5:
        return 2 * np.pi * observations[:, 4].astype(float)
    return np.arctan2(observations[:, 5].astype(float), observations[:, 4].astype(float))


def crashed(observations: np.ndarray) -> np.ndarray:
    """Whether the rectangle of a car touches Carlo's disc or ring, by its corners and sides."""
    x, y = (60 * observations[:, k].astype(float) - 30 for k in (0, 1))
    psi = heading(observations)
    corners = []
    for along, aside in ((2, 1), (-2, 1), (-2, -1), (2, -1)):
        corners.append(
            np.stack(
                [
                    x + along * np.cos(psi) - aside * np.sin(psi),
                    y + along * np.sin(psi) + aside * np.cos(psi),
                ],
                axis=1,
            )
        )
    outside = np.max([np.hypot(*c.T) for c in corners], axis=0) >= 27.5
    nearest = np.full(len(x), np.inf)
    left_of_all = np.ones(len(x), bool)
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        side = b - a
        share = np.clip(-(a * side).sum(axis=1) / (side * side).sum(axis=1), 0, 1)
        nearest = np.minimum(nearest, np.hypot(*(a + share[:, None] * side).T))
        left_of_all &= side[:, 0] * -a[:, 1] - side[:, 1] * -a[:, 0] >= 0
    return outside | (nearest <= 15) | left_of_all


def region(x: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda o: np.hypot(60 * o[:, 0].astype(float) - x, 60 * o[:, 1].astype(float) - 30) < 5


ROAD = bits(region(51.25), region(8.75), crashed)


def room(name: str) -> Callable[[np.ndarray], np.ndarray]:
    x, y = (10 * int(digit) - 6 for digit in name)
    return lambda o: np.maximum(np.abs(o[:, 0] - x), np.abs(o[:, 1] - y)) <= 2


def rooms(names: str) -> Callable[[np.ndarray], np.ndarray]:
    """Labels of rooms as "12 14" and, at last, of having hit a wall."""
    return bits(*(room(name) for name in names.split()), lambda o: o[:, 2] == 1)


ROOMS = rooms("12 14 34 32 31 33 44 43")
ROOMS_PROSE = rooms("12 14 34 32 33 44 43")
BOTH_LOOPS = around("abcd", "efcgh", avoid="z")
BOTH_LOOPS_PROSE = around("abcd", "ecfg", avoid="z")
