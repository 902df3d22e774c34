"""Progression: what is left to satisfy after a letter (Esparza, Křetínský, Sickert, LICS 2018, 4)."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from functools import cache

from tiloilc.ltl.ast import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    conjunction,
    disjunction,
)


def unfold(formula: Formula) -> Formula:
    """The expansion laws, applied outside every X: `F a` becomes `a | X F a`. NNF in, NNF out."""

    @cache
    def go(f: Formula) -> Formula:
        match f:
            case And(operands):
                return conjunction(go(o) for o in operands)
            case Or(operands):
                return disjunction(go(o) for o in operands)
            case Eventually(operand):
                return disjunction((go(operand), Next(f)))
            case Always(operand):
                return conjunction((go(operand), Next(f)))
            case Until(left, right) | WeakUntil(left, right):
                return disjunction((go(right), conjunction((go(left), Next(f)))))
            case Release(left, right) | StrongRelease(left, right):
                return conjunction((go(right), disjunction((go(left), Next(f)))))
            case _:
                return f

    return go(formula)


def after(formula: Formula, letter: AbstractSet[str]) -> Formula:
    """af(formula, letter): w satisfies it just if letter · w satisfies `formula`.

    `formula` in negation normal form; `letter` names the propositions that hold.
    """

    @cache
    def go(f: Formula) -> Formula:
        match f:
            case Constant():
                return f
            case Proposition(name):
                return Constant(name in letter)
            case Not(Proposition(name)):
                return Constant(name not in letter)
            case And(operands):
                return conjunction(go(o) for o in operands)
            case Or(operands):
                return disjunction(go(o) for o in operands)
            case Next(operand):
                return operand
            case Eventually(operand):
                return disjunction((go(operand), f))
            case Always(operand):
                return conjunction((go(operand), f))
            case Until(left, right) | WeakUntil(left, right):
                return disjunction((go(right), conjunction((go(left), f))))
            case Release(left, right) | StrongRelease(left, right):
                return conjunction((go(right), disjunction((go(left), f))))
            case _:
                raise AssertionError(f"not in negation normal form: {f!r}")

    return go(formula)
