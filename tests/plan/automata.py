"""Automata of the paper's tasks, written down by hand."""

from collections.abc import Callable, Sequence

from tiloilc.automaton.ldba import Cube, Edge, Ldba


def automaton(
    propositions: Sequence[str],
    states: int,
    step: Callable[[int, set[str]], int],
    accepting: set[int],
    sink: int | None = None,
    jumps: Sequence[tuple[int, int]] = (),
) -> Ldba:
    """An automaton by its step function, with one cube for each letter."""
    full = (1 << len(propositions)) - 1
    guards: dict[tuple[int, int], list[Cube]] = {}
    for b in range(states):
        for letter in range(full + 1):
            true = {name for i, name in enumerate(propositions) if letter >> i & 1}
            target = sink if b == sink else step(b, true)
            assert target is not None
            guards.setdefault((b, target), []).append(Cube(full, letter))
    edges = tuple(Edge(b, c, tuple(guard)) for (b, c), guard in sorted(guards.items()))
    names = tuple(f"state {b}" for b in range(states))
    return Ldba(tuple(propositions), names, frozenset(accepting), sink, edges, tuple(jumps))


def ring(goals: Sequence[str], avoid: str) -> Ldba:
    """`GF(g0 & XF(g1 & …)) & G !avoid`: one state a goal, the accepting one, the sink."""
    n = len(goals)

    def step(b: int, true: set[str]) -> int:
        if avoid in true:
            return n + 1
        waits = b % n
        return waits + 1 if goals[waits] in true else waits

    return automaton([*goals, avoid], n + 2, step, {n}, n + 1)


def flatworld_cycle() -> Ldba:
    """`GF(r & XF(g & XF y)) & G !b`."""
    return ring(["r", "g", "y"], "b")


def chain(goals: Sequence[str]) -> Ldba:
    """`F(g0 & XF(g1 & …))`: acceptance is absorbing."""
    n = len(goals)

    def step(b: int, true: set[str]) -> int:
        return b + 1 if b < n and goals[b] in true else b

    return automaton(goals, n + 1, step, {n})


def stabilization() -> Ldba:
    """`FG y & G !b`: 0 waits, the jump to 1 promises y for ever, 2 is the sink."""

    def step(b: int, true: set[str]) -> int:
        if "b" in true:
            return 2
        return 0 if b == 0 else (1 if "y" in true else 2)

    return automaton(["y", "b"], 3, step, {1}, 2, [(0, 1)])


def response() -> Ldba:
    """`G(a -> F(b & XF c))`: the start accepts."""

    def step(b: int, true: set[str]) -> int:
        if b == 0:
            return 1 if "a" in true else 0
        if b == 1:
            return 2 if "b" in true else 1
        return 0 if "c" in true else 2

    return automaton(["a", "b", "c"], 3, step, {0})


def disjunction() -> Ldba:
    """`F(a & XF g) | F(b & XF g)` with a state for each side: 3 accepts."""

    def step(b: int, true: set[str]) -> int:
        if b == 0:
            return 1 if "a" in true else 2 if "b" in true else 0
        if b == 3 or "g" in true:
            return 3
        return 2 if b == 1 and "b" in true else b

    return automaton(["a", "b", "g"], 4, step, {3})


def fork() -> Ldba:
    """`GF a | GF b`: 0 jumps to 1, which accepts in 3, or to 2, which accepts in 4."""

    def step(b: int, true: set[str]) -> int:
        if b == 0:
            return 0
        side = 1 if b in (1, 3) else 2
        return side + 2 if "ab"[side - 1] in true else side

    return automaton(["a", "b"], 5, step, {3, 4}, None, [(0, 1), (0, 2)])
