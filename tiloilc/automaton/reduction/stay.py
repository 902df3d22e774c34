"""Accept while waiting, where a jump only says that one stays.

A construction may give `G (a | b W c)` a jump for each place where a run can stay for ever. If all
that stays there is accepted, nobody has to guess anything: the edges are marked, the jumps go.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import Draft, Row, components
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
    pairs = [(q, len(draft.rows) + i) for i, q in enumerate(waiting)]
    while True:
        both = _with_copies(draft, waiting, component, marked, diagrams)
        following = Following.of(both, diagrams, taken=range(len(draft.rows)))
        if following is None:
            return draft
        good = [pair for pair, ok in zip(pairs, following.followed(pairs), strict=True) if ok]
        too_much = marked - {component[q] for q, _ in good}
        too_much |= {component[q] for q, t in pairs if (q, t) not in good} & marked
        if not too_much:
            break
        marked -= too_much
    inclusion = Inclusion(both, diagrams, pairs)
    lead = list(range(len(both.rows)))
    for q, copy in good:
        if inclusion.holds(q, copy):
            lead[q] = copy
    return redirect(both, lead, diagrams) if lead != sorted(lead) else draft


def _with_copies(
    draft: Draft,
    waiting: Sequence[int],
    component: Sequence[int],
    marked: Set[int],
    diagrams: Diagrams,
) -> Draft:
    """`draft` with a copy of each of `waiting` behind it, in their order, and no jumps there."""
    copy = {q: len(draft.rows) + i for i, q in enumerate(waiting)}
    rows: list[Row] = []
    for q in waiting:
        row: Row = {}
        for (t, _), guard in draft.rows[q].items():
            key = (copy.get(t, t), component[t] == component[q] and component[q] in marked)
            row[key] = diagrams.disj(row.get(key, FALSE), guard)
        rows.append(row)
    return replace(
        draft,
        rows=(*draft.rows, *rows),
        jumps=(*draft.jumps, *((),) * len(rows)),
        names=(*draft.names, *(draft.names[q] for q in waiting)),
        steps=(*draft.steps, *(draft.steps[q] for q in waiting if draft.steps)),
    )
