"""Formulas side by side: words that tell them apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tiloilc.automaton.language.questions import equivalent, small_budget
from tiloilc.automaton.language.words import accepted_word
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT
from tiloilc.automaton.translate import translate
from tiloilc.diag import CompileError
from tiloilc.ltl import Lasso, propositions_of, subformulas
from tiloilc.ltl.ast import (
    TRUE,
    And,
    Binary,
    Formula,
    Junction,
    Not,
    Proposition,
    Unary,
    conjunction,
    disjunction,
)

RELEVANCE_NAMES = 40
"""Of more propositions nobody asks which matter."""


def satisfying_word(
    formula: Formula,
    propositions: Sequence[str],
    *,
    max_states: int = MAX_STATES,
    timeout: float = TIMEOUT,
) -> Lasso | None:
    """A short word that satisfies `formula`; None if there is none.

    Raises CompileError AUT305 when a limit (`translate`) is reached.
    """
    ldba = translate(
        formula, propositions, acceptance="edge", max_states=max_states, timeout=timeout
    )
    return accepted_word(ldba)


def difference_word(
    left: Formula,
    right: Formula,
    propositions: Sequence[str],
    *,
    max_states: int = MAX_STATES,
    timeout: float = TIMEOUT,
) -> Lasso | None:
    """A short word of `left` that is none of `right`; None if `left` implies `right`.

    `left` and `right` are equivalent if both directions give None. Raises CompileError AUT305.
    """
    both = conjunction((left, Not(right)))
    return satisfying_word(both, propositions, max_states=max_states, timeout=timeout)


def irrelevant_propositions(formula: Formula, propositions: Sequence[str]) -> Iterator[str]:
    """The propositions of `formula` on which its language does not depend.

    Ends early where the comparison would take too long.
    """
    budget = small_budget()
    names = propositions_of(formula)
    for name in names if len(names) <= RELEVANCE_NAMES else ():
        try:
            if equivalent(formula, _always_true(formula, name), propositions, budget):
                yield name
        except CompileError:
            return


def _always_true(formula: Formula, name: str) -> Formula:
    """`formula` with `true` for the proposition `name`."""
    done: dict[Formula, Formula] = {}
    for node in subformulas(formula):
        if isinstance(node, Proposition):
            done[node] = TRUE if node.name == name else node
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
