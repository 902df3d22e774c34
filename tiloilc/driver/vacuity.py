"""Parts of a formula that do not matter (Beer, Ben-David, Eisner, Rodeh, FMSD 2001: vacuity)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tiloilc.automaton import difference_word
from tiloilc.diag import CompileError
from tiloilc.ltl import subformulas
from tiloilc.ltl.ast import (
    FALSE,
    TRUE,
    And,
    Binary,
    Constant,
    Formula,
    Junction,
    Unary,
    conjunction,
    disjunction,
)

MAX_PARTS = 40
MAX_STATES = 200
SECONDS = 0.5
"""Beyond these nobody asks: a comparison takes milliseconds on formulas that people write."""


def irrelevant_parts(formula: Formula, propositions: Sequence[str]) -> Iterator[Formula]:
    """The largest sub-formulas that true or false may replace, wherever they occur, for the same.

    Ends early where the comparison would take too long. The formula itself is left out: it is
    unsatisfiable or always true, which says more.
    """
    parts = subformulas(formula)
    if len(parts) > MAX_PARTS:
        return
    told: set[Formula] = set()
    for part in reversed(parts[:-1]):
        if isinstance(part, Constant) or part in told:
            continue
        try:
            matters = not any(
                _equivalent(formula, replaced(formula, part, value), propositions)
                for value in (FALSE, TRUE)
            )
        except CompileError:
            return
        if not matters:
            told.update(subformulas(part))
            yield part


def replaced(formula: Formula, part: Formula, value: Formula) -> Formula:
    """`formula` with `value` for every `part`."""
    done: dict[Formula, Formula] = {}
    for node in subformulas(formula):
        if node == part:
            done[node] = value
        elif isinstance(node, Unary):
            done[node] = type(node)(done[node.operand])
        elif isinstance(node, Binary):
            done[node] = type(node)(done[node.left], done[node.right])
        elif isinstance(node, Junction):
            join = conjunction if isinstance(node, And) else disjunction
            done[node] = join(done[operand] for operand in node.operands)
        else:
            done[node] = node
    return done[formula]


def _equivalent(left: Formula, right: Formula, propositions: Sequence[str]) -> bool:
    return all(
        difference_word(one, other, propositions, max_states=MAX_STATES, timeout=SECONDS) is None
        for one, other in ((left, right), (right, left))
    )
