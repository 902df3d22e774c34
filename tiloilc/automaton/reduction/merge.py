"""Merge states that accept the same words."""

from __future__ import annotations

from functools import cache, partial

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft, on_cycles
from tiloilc.automaton.reduction.follow import Following
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion
from tiloilc.automaton.reduction.jumps import waiting_states
from tiloilc.automaton.reduction.quotient import redirect


def merge_by_language(draft: Draft, diagrams: Diagrams) -> Draft:
    """Lead what enters a state to one of the same language further on, if there is one.

    Only towards deterministic states of a component that comes later in a fixed order, so that a
    run is redirected finitely often. A waiting state becomes one that accepts the same without a
    jump: there was nothing to guess.
    """
    component, looping = on_cycles(draft)
    waiting = waiting_states(draft)
    fixed = [q for q in range(len(draft.rows)) if q not in waiting]
    pairs = [(q, t) for q in sorted(waiting) for t in fixed]
    pairs += [(q, t) for q in fixed for t in fixed if component[q] != component[t]]
    if len(pairs) > MAX_PAIRS:
        return draft
    inclusion = Inclusion(draft, diagrams, pairs)
    known = set(pairs)
    following = cache(partial(Following.of, draft, diagrams))
    block = list(range(len(draft.rows)))

    def covers(q: int, t: int) -> bool:
        """Whether q accepts all that t accepts."""
        if q not in waiting:
            return inclusion.holds(t, q)
        follower = None if t in draft.jumps[q] else following()
        return t in draft.jumps[q] or (follower is not None and follower.follows(q, t))

    for q in block:
        further = [t for t in fixed if (q, t) in known and component[t] < component[q]]
        further.sort(key=lambda t: (component[t], not looping[t], t))
        same = (t for t in further if inclusion.holds(q, t) and covers(q, t))
        block[q] = next(same, q)
    if block == list(range(len(block))):
        return draft
    return redirect(draft, block, diagrams)
