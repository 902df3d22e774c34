"""Accept while waiting, where a jump only says that one stays.

A construction may give `G (a | b W c)` a jump for each place where a run can stay for ever. If all
that stays there is accepted, nobody has to guess anything: the edges are marked, the jumps go.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import Draft, Row, components, with_copies
from tiloilc.automaton.reduction.follow import Following
from tiloilc.automaton.reduction.inclusion import Inclusion
from tiloilc.automaton.reduction.jumps import waiting_states
from tiloilc.automaton.reduction.quotient import redirect

MAX_WAITING = 24
"""Waiting states to compare with copies that accept: beyond, it costs more than it saves."""


def accept_waiting(draft: Draft, diagrams: Diagrams) -> Draft:
    """Make waiting states deterministic that accept just what stays in some of their components.

    Each has a copy without jumps, on whose edges within its component there are marks. If the
    copies of a component accept more than they may, these marks go. A state whose copy accepts
    all that it accepts itself gives way to it.
    """
    waiting = sorted(waiting_states(draft))
    if not waiting or len(waiting) > MAX_WAITING:
        return draft
    component = components([[t for t, _ in row] for row in draft.rows])
    marked = {component[q] for q in waiting}
    count = len(draft.rows)
    pairs = [(q, count + i) for i, q in enumerate(waiting)]
    while True:
        rows = _accepting_rows(draft, dict(pairs), component, marked, diagrams)
        both = with_copies(draft, waiting, rows)
        following = Following.of(both, diagrams, taken=range(count))
        if following is None:
            return draft
        good = dict(zip(waiting, following.followed(pairs), strict=True))
        too_much = {component[q] for q in waiting if not good[q]} & marked
        if not too_much:
            break
        marked -= too_much
    inclusion = Inclusion(both, diagrams, pairs)
    same = {q: copy for q, copy in pairs if good[q] and inclusion.holds(q, copy)}
    if not same:
        return draft
    return redirect(both, [same.get(q, q) for q in range(len(both.rows))], diagrams)


def _accepting_rows(
    draft: Draft,
    copy: Mapping[int, int],
    component: Sequence[int],
    marked: Set[int],
    diagrams: Diagrams,
) -> list[Row]:
    """The edges of the copies, with marks within the components `marked`."""
    rows: list[Row] = []
    for q in copy:
        row: Row = {}
        for (t, _), guard in draft.rows[q].items():
            key = (copy.get(t, t), component[t] == component[q] and component[q] in marked)
            row[key] = diagrams.disj(row.get(key, FALSE), guard)
        rows.append(row)
    return rows
