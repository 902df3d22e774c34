"""Merge states that accept the same words."""

from __future__ import annotations

from dataclasses import replace

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft, on_cycles
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion
from tiloilc.automaton.reduction.jumps import waiting_states
from tiloilc.automaton.reduction.quotient import merged_row


def merge_by_language(draft: Draft, diagrams: Diagrams) -> Draft:
    """Lead what enters a state to one of the same language further on, if there is one.

    Only towards deterministic states of a component that comes later in a fixed order, so that a
    run is redirected finitely often. A waiting state whose jump covers its language becomes that
    jump's target: there was nothing to guess.
    """
    component, looping = on_cycles(draft)
    waiting = waiting_states(draft)
    fixed = [q for q in range(len(draft.rows)) if q not in waiting]
    pairs = [(q, t) for q in sorted(waiting) for t in draft.jumps[q]]
    pairs += [(q, t) for q in fixed for t in fixed if component[q] != component[t]]
    if len(pairs) > MAX_PAIRS:
        return draft
    inclusion = Inclusion(draft, diagrams, pairs)
    known = set(pairs)
    block = list(range(len(draft.rows)))
    for q in block:
        same = [
            t
            for t in fixed
            if (q, t) in known
            and component[t] < component[q]
            and inclusion.holds(q, t)
            and (q in waiting or inclusion.holds(t, q))
        ]
        if same:
            block[q] = min(same, key=lambda t: (component[t], not looping[t], t))
    if block == list(range(len(block))):
        return draft
    return replace(
        draft,
        rows=tuple(merged_row(row, block, diagrams) for row in draft.rows),
        jumps=tuple(tuple(sorted({block[t] for t in targets})) for targets in draft.jumps),
        initial=block[draft.initial],
    )
