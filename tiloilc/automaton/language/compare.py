"""Formulas side by side: words that tell them apart."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.automaton.language.words import accepted_word
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT
from tiloilc.automaton.translate import translate
from tiloilc.ltl import Lasso
from tiloilc.ltl.ast import Formula, Not, conjunction


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
