"""Fragments of LTL that are seen from the syntax: safety, co-safety, pure eventuality.

Safety and co-safety: Sistla, Safety, Liveness and Fairness in Temporal Logic (1994). Eventuality
and universality: Etessami and Holzmann, Optimizing Büchi Automata (CONCUR 2000), section 4.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import TypeVar

from tiloilc.ltl.ast import (
    Always,
    Constant,
    Eventually,
    Formula,
    Next,
    Not,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    subformulas,
)
from tiloilc.ltl.normal import nnf

REMEMBERED = 1 << 16
"""Answers kept: the rules ask about the same sub-formulas again and again."""

T = TypeVar("T")


def remembered(ask: Callable[[Formula, Callable[[Formula], T]], T]) -> Callable[[Formula], T]:
    """A question that is asked of the operands too (`ask` is given itself), its answers kept.

    The recursion is that of the formula; where that is too deep, the operands are asked first.
    """

    @lru_cache(maxsize=REMEMBERED)
    def again(formula: Formula) -> T:
        return ask(formula, again)

    @wraps(ask)
    def asked(formula: Formula) -> T:
        try:
            return again(formula)
        except RecursionError:
            for part in subformulas(formula):
                again(part)
            return again(formula)

    return asked


def is_safety(formula: Formula) -> bool:
    """Whether the normal form has no F, U and M: a violation shows after finitely many letters."""
    return not _has(formula, (Eventually, Until, StrongRelease))


def is_cosafety(formula: Formula) -> bool:
    """Whether the normal form has no G, W and R: success shows after finitely many letters."""
    return not _has(formula, (Always, WeakUntil, Release))


def is_propositional(formula: Formula) -> bool:
    """Whether the formula has no temporal operator: the first letter decides."""
    binary = (Until, WeakUntil, Release, StrongRelease)
    return not any(
        isinstance(part, (Next, Eventually, Always, *binary)) for part in subformulas(formula)
    )


def _has(formula: Formula, kinds: tuple[type[Formula], ...]) -> bool:
    return any(isinstance(part, kinds) for part in subformulas(nnf(formula)))


@remembered
def is_eventual(formula: Formula, again: Callable[[Formula], bool]) -> bool:
    """A pure eventuality: true of every word that has a suffix of which it is true. NNF."""
    match formula:
        case Constant() | Eventually():
            return True
        case Proposition() | Not():
            return False
        case Until(_, right):
            return again(right)
        case _:
            return all(again(child) for child in formula.children)


@remembered
def is_universal(formula: Formula, again: Callable[[Formula], bool]) -> bool:
    """Purely universal: true of every suffix of a word of which it is true. NNF."""
    match formula:
        case Constant() | Always():
            return True
        case Proposition() | Not():
            return False
        case Release(_, right):
            return again(right)
        case _:
            return all(again(child) for child in formula.children)


def is_suspendable(formula: Formula) -> bool:
    """Both: no finite beginning of a word has a say in it, as in G F a. NNF."""
    return is_eventual(formula) and is_universal(formula)
