"""Merge states that cannot be told apart step by step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tiloilc.automaton.bdd import FALSE, Diagrams
from tiloilc.automaton.draft import Draft, Row


def quotient(draft: Draft, diagrams: Diagrams) -> Draft:
    """Merge bisimilar states: same letters to the same classes with the same marks, same jumps."""
    block = [0] * len(draft.rows)
    count = 1
    while True:
        signatures: dict[object, int] = {}
        refined = []
        for q, row in enumerate(draft.rows):
            diagrams.budget.tick()
            signature = (
                block[q],
                frozenset(merged_row(row, block, diagrams).items()),
                frozenset(block[t] for t in draft.jumps[q]),
            )
            refined.append(signatures.setdefault(signature, len(signatures)))
        block = refined
        if len(signatures) == count:
            break
        count = len(signatures)
    first: dict[int, int] = {}
    for q, number in enumerate(block):
        first.setdefault(number, q)
    return replace(
        draft,
        rows=tuple(merged_row(draft.rows[q], block, diagrams) for q in first.values()),
        jumps=tuple(
            tuple(sorted({block[t] for t in draft.jumps[q]} - {block[q]})) for q in first.values()
        ),
        initial=block[draft.initial],
        names=tuple(draft.names[q] for q in first.values()),
        steps=tuple(draft.steps[q] for q in first.values() if draft.steps),
    )


def merged_row(row: Row, block: Sequence[int], diagrams: Diagrams) -> Row:
    """`row` with targets replaced by `block[target]`."""
    new: Row = {}
    for (target, mark), guard in row.items():
        key = (block[target], mark)
        new[key] = diagrams.disj(new.get(key, FALSE), guard)
    return new


def redirect(draft: Draft, lead: Sequence[int], diagrams: Diagrams) -> Draft:
    """`draft` where `lead[q]` is entered in place of q, by edges, by jumps and at the start."""
    return replace(
        draft,
        rows=tuple(merged_row(row, lead, diagrams) for row in draft.rows),
        jumps=tuple(tuple(sorted({lead[t] for t in targets})) for targets in draft.jumps),
        initial=lead[draft.initial],
    )
