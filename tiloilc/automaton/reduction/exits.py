"""Jump to stay: what leads on from where a jump leads can be left to those who wait."""

from __future__ import annotations

from dataclasses import replace

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft, Row, reachable, with_copies
from tiloilc.automaton.reduction.follow import Following
from tiloilc.automaton.reduction.trim import trim

MAX_STATES = 40
"""States of automata to try this on: beyond, it costs more than it saves."""


def cut_exits(draft: Draft, diagrams: Diagrams) -> Draft:
    """Cut the edges out of states on a loop that only jumps lead to, if nobody misses them.

    Who jumped to `a W b` too early waits for b there, who did not jump sees b come: it is enough to
    jump to `G a`, once that is settled. All such states are cut, or none.
    """
    if not any(draft.jumps) or len(draft.rows) > MAX_STATES:
        return draft
    plain = reachable([[t for t, _ in row] for row in draft.rows], [draft.initial])
    ahead = [q for q in range(len(draft.rows)) if q not in plain]
    cut = {q for q in ahead if (q, True) in draft.rows[q] and len(draft.rows[q]) > 1}
    cut = {q for q in cut if (q, False) not in draft.rows[q] and _is_alone(draft, q)}
    if not cut:
        return draft
    count = len(draft.rows)
    copy = {q: count + i for i, q in enumerate(ahead)}
    rows: list[Row] = []
    for q in ahead:
        edges = draft.rows[q].items()
        rows.append(
            {(copy.get(t, t), m): guard for (t, m), guard in edges if q not in cut or t == q}
        )
    both = with_copies(draft, ahead, rows)
    both = replace(
        both,
        jumps=tuple(tuple(copy.get(t, t) for t in targets) for targets in both.jumps),
        names=(*draft.names, *(None if q in cut else draft.names[q] for q in ahead)),
    )
    taken = [u for u in range(len(both.rows)) if u >= count or u in plain]
    following = Following.of(both, diagrams, followed=range(count), taken=taken)
    jumps = [(q, t) for q, targets in enumerate(draft.jumps) for t in targets]
    if following is None or not all(following.followed(jumps)):
        return draft
    fewer = trim(both, diagrams)
    return fewer if len(fewer.rows) < count else draft


def _is_alone(draft: Draft, state: int) -> bool:
    """Whether no other state of its component has `state`."""
    others = {t for t, _ in draft.rows[state]} - {state}
    return state not in reachable([[t for t, _ in row] for row in draft.rows], others)
