"""Jumps one letter on, from and to states on cycles."""

from __future__ import annotations

from dataclasses import replace

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import Draft, on_cycles, reachable, reversed_graph


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
