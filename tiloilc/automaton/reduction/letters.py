"""Guards as bits, one for each class of letters that no guard of the automaton tells apart.

Comparing the languages of states intersects guards by the million; bits do it in one operation.
"""

from __future__ import annotations

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import Draft

MAX_VARIABLES = 12
"""Propositions in guards for which a bit stands for a letter: 512 bytes a guard."""

MAX_CLASSES = 4_096
"""Classes of letters: beyond, languages are not compared."""

Moves = list[tuple[int, bool, int]]
"""The edges of a state: target, whether it accepts, letters as bits."""


def moves(draft: Draft, diagrams: Diagrams) -> list[Moves] | None:
    """The edges of all states; None if there are too many classes of letters."""
    guards = dict.fromkeys(guard for row in draft.rows for guard in row.values())
    support = sorted({v for guard in guards for v in diagrams.support(guard)})
    if len(support) <= MAX_VARIABLES:
        variables = tuple(support)
        bits = {guard: diagrams.table(guard, variables) for guard in guards}
    else:
        classes = _classes(list(guards), diagrams)
        if classes is None:
            return None
        bits = {
            guard: sum(1 << i for i, c in enumerate(classes) if diagrams.conj(c, guard) != FALSE)
            for guard in guards
        }
    return [[(t, mark, bits[guard]) for (t, mark), guard in row.items()] for row in draft.rows]


def _classes(guards: list[Node], diagrams: Diagrams) -> list[Node] | None:
    """The coarsest partition of the letters that splits no guard."""
    classes = [TRUE]
    for guard in guards:
        diagrams.budget.tick()
        split = []
        for letters in classes:
            split += [diagrams.conj(letters, guard), diagrams.minus(letters, guard)]
        classes = [letters for letters in split if letters != FALSE]
        if len(classes) > MAX_CLASSES:
            return None
    return classes
