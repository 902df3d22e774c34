"""Where an agent may go on each letter, as a table over letter sets (free ε-jumps)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tiloilc.automaton.ldba import Cube, Ldba, StateId


@dataclass(frozen=True, slots=True)
class Option:
    """In `state`, on the letters of `guard`, the agent may go to any of `targets`."""

    state: StateId
    guard: tuple[Cube, ...]
    targets: tuple[StateId, ...]


def options(ldba: Ldba) -> tuple[Option, ...]:
    """All rows with a choice, by state: δ's target first, then by each jump, dead ones left out.

    Letters with just one possibility have no row: δ says where they lead. (Where δ leads to the
    sink and one jump does not, there is a row.)
    """
    rows = []
    for b in ldba.states:
        if not ldba.jump_targets[b]:
            continue
        parts: dict[tuple[StateId, ...], list[Cube]] = {}
        meets: list[tuple[tuple[StateId, ...], Cube]] = [
            ((edge.target,), cube) for edge in ldba.outgoing[b] for cube in edge.guard
        ]
        for jumped in ldba.jump_targets[b]:
            meets = [
                ((*reached, edge.target), both)
                for reached, cube in meets
                for edge in ldba.outgoing[jumped]
                for other in edge.guard
                if (both := intersection(cube, other)) is not None
            ]
        for reached, cube in meets:
            live = tuple(dict.fromkeys(c for c in reached if c != ldba.sink)) or reached[:1]
            if live != reached[:1]:
                parts.setdefault(live, []).append(cube)
        rows += [Option(b, tuple(sorted(set(parts[t]))), t) for t in sorted(parts)]
    return tuple(rows)


def intersection(one: Cube, other: Cube) -> Cube | None:
    """The letters of both cubes, None if there are none."""
    if (one.value ^ other.value) & one.mask & other.mask:
        return None
    return Cube(one.mask | other.mask, one.value | other.value)


def is_partition(guards: Sequence[Sequence[Cube]]) -> bool:
    """Whether each letter is in just one of `guards`; the cubes of one may overlap."""
    apart = all(
        intersection(cube, other) is None
        for i, guard in enumerate(guards)
        for cube in guard
        for earlier in guards[:i]
        for other in earlier
    )
    return apart and _covers([cube for guard in guards for cube in guard])


def _covers(cubes: Sequence[Cube]) -> bool:
    """Whether each letter is in one of `cubes`, by cases on the propositions that they name."""
    waiting = [list(cubes)]
    while waiting:
        case = waiting.pop()
        if not case:
            return False
        if all(cube.mask for cube in case):
            bit = case[0].mask & -case[0].mask
            for value in (0, bit):
                fitting = [c for c in case if not c.mask & bit or c.value & bit == value]
                waiting.append([Cube(c.mask & ~bit, c.value & ~bit) for c in fitting])
    return True
