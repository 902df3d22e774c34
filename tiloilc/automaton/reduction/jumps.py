"""Fewer jumps: later ones instead of those from or to states on no cycle, none that adds nothing."""

from __future__ import annotations

from dataclasses import replace

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import Draft, on_cycles, reachable, reversed_graph
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion


def delay_jumps(draft: Draft, diagrams: Diagrams) -> Draft:
    """Move jumps from or to a state on no cycle one letter on, until none is left.

    The language of a jump's target is part of its source's, so a jump one letter later is allowed
    wherever the source's successor can be reached; states that no jump needs any more go.
    """
    _, looping = on_cycles(draft)
    waiting = waiting_states(draft)
    jumps = [dict.fromkeys(targets) for targets in draft.jumps]
    work = [(q, t) for q in range(len(jumps)) for t in jumps[q]]
    done = set(work)
    while work:
        diagrams.budget.tick()
        source, target = work.pop()
        if looping[source] and looping[target]:
            continue
        del jumps[source][target]
        for (s, _), guard in draft.rows[source].items():
            for (t, _), other in draft.rows[target].items():
                if s == t or s not in waiting or diagrams.conj(guard, other) == FALSE:
                    continue
                jumps[s].setdefault(t)
                if (s, t) not in done:
                    done.add((s, t))
                    work.append((s, t))
    return replace(draft, jumps=tuple(tuple(sorted(targets)) for targets in jumps))


def waiting_states(draft: Draft) -> set[int]:
    """The states from which a jump can still be taken."""
    graph = [draft.targets(q) for q in range(len(draft.rows))]
    return reachable(reversed_graph(graph), [q for q, t in enumerate(draft.jumps) if t])


def drop_jumps(draft: Draft, diagrams: Diagrams) -> Draft:
    """Drop a jump if another one of the same state, or waiting without a jump, covers it."""
    pairs = [(s, t) for targets in draft.jumps for s in targets for t in targets if s != t]
    pairs += [(t, q) for q, targets in enumerate(draft.jumps) for t in targets]
    if not pairs or len(pairs) > MAX_PAIRS:
        return draft
    inclusion = Inclusion(draft, diagrams, pairs)
    jumps = []
    for q, targets in enumerate(draft.jumps):
        kept = [t for t in targets if not inclusion.holds(t, q)]
        for target in reversed(kept):
            others = [t for t in kept if t != target]
            if any(inclusion.holds(target, t) for t in others):
                kept = others
        jumps.append(tuple(kept))
    return replace(draft, jumps=tuple(jumps))
