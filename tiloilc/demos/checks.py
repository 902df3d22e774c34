"""Whether demonstrations fit the task (contract, section 4: DEMO501 to DEMO504)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tiloilc.automaton.ldba import Edge, Ldba, StateId
from tiloilc.demos.model import DemoSet
from tiloilc.demos.replay import Replay
from tiloilc.diag import Diagnostic, Span, counted


def check_shape(demos: DemoSet, dimensions: int, span: Span | None = None) -> list[Diagnostic]:
    """DEMO504 if demonstrated states do not have the environment's `dimensions`."""
    if demos.dimensions == dimensions:
        return []
    given = counted(demos.dimensions, "component")
    return [Diagnostic.of("DEMO504", span, given=given, expected=dimensions)]


def check_replays(
    replays: Sequence[Replay], ldba: Ldba, span: Span | None = None
) -> list[Diagnostic]:
    """DEMO501, DEMO502 and DEMO503 for demonstrations that were run through the automaton."""
    if not replays:
        return []
    seen = 0
    for run in replays:
        seen |= int(np.bitwise_or.reduce(run.letters))
    found = [
        Diagnostic.of("DEMO501", span, name=name, help="check its predicate and the demonstrations")
        for i, name in enumerate(ldba.propositions)
        if not seen >> i & 1 and is_needed(ldba, i)
    ]
    found += [Diagnostic.of("DEMO502", span, stage=b) for b in _never_left(replays, ldba)]
    found += [
        Diagnostic.of("DEMO503", span, index=index, step=run.violates_at)
        for index, run in enumerate(replays)
        if run.violates_at is not None
    ]
    return found


def is_needed(ldba: Ldba, proposition: int) -> bool:
    """Whether nothing is accepted unless the proposition is true at some time.

    So `r` is in `F r & G !b`, but `b` is not, and neither alternative of `F r | F y` is.
    """
    bit = 1 << proposition
    steps: dict[StateId, set[StateId]] = {b: set() for b in ldba.states}
    for edge in ldba.edges:
        if _without(edge, bit):
            steps[edge.source].add(edge.target)
    for b in ldba.states:
        for target in ldba.jump_targets[b]:
            steps[b] |= {e.target for e in ldba.outgoing[target] if _without(e, bit)}
    live = _reachable(steps, {ldba.initial})
    return not any(b in _reachable(steps, steps[b]) for b in ldba.accepting & live)


def _without(edge: Edge, bit: int) -> bool:
    """Whether a letter without the proposition takes the edge."""
    return any(not cube.mask & bit or not cube.value & bit for cube in edge.guard)


def _reachable(steps: dict[StateId, set[StateId]], start: set[StateId]) -> set[StateId]:
    found, waiting = set(start), sorted(start)
    while waiting:
        fresh = steps[waiting.pop()] - found
        found |= fresh
        waiting.extend(sorted(fresh))
    return found


def _never_left(replays: Sequence[Replay], ldba: Ldba) -> list[StateId]:
    """States short of acceptance that are reached, and that no demonstration leaves alive."""
    reached: set[StateId] = set()
    left: set[StateId] = set()
    for run in replays:
        path = [ldba.initial, *run.states.tolist()]
        reached.update(path[1:])
        left.update(b for b, after in pairwise(path) if after not in (b, ldba.sink))
    return sorted(reached - left - ldba.accepting - {ldba.sink})
