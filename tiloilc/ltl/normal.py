"""Negation normal form: negation stands before propositions only."""

from __future__ import annotations

from functools import cache

from tiloilc.ltl.ast import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
    conjunction,
    disjunction,
)


def nnf(formula: Formula) -> Formula:
    """`formula` without ->, <-> and xor, negation on propositions only.

    F, G, U, W, R, M, X are kept, junctions come out flat and in the written order. Equal
    sub-formulas become one object, so that a tower of <-> takes linear space.
    """

    @cache
    def go(f: Formula, positive: bool) -> Formula:
        match f:
            case Proposition():
                return f if positive else Not(f)
            case Constant(value):
                return Constant(value == positive)
            case Not(operand):
                return go(operand, not positive)
            case And(operands):
                return (conjunction if positive else disjunction)(go(o, positive) for o in operands)
            case Or(operands):
                return (disjunction if positive else conjunction)(go(o, positive) for o in operands)
            case Implies(left, right):
                join = disjunction if positive else conjunction
                return join((go(left, not positive), go(right, positive)))
            case Iff(left, right):
                return same(left, right, positive)
            case Xor(left, right):
                return same(left, right, not positive)
            case Next(operand):
                return Next(go(operand, positive))
            case Eventually(operand):
                return (Eventually if positive else Always)(go(operand, positive))
            case Always(operand):
                return (Always if positive else Eventually)(go(operand, positive))
            case Until(left, right):
                return (Until if positive else Release)(go(left, positive), go(right, positive))
            case Release(left, right):
                return (Release if positive else Until)(go(left, positive), go(right, positive))
            case WeakUntil(left, right):
                kind = WeakUntil if positive else StrongRelease
                return kind(go(left, positive), go(right, positive))
            case StrongRelease(left, right):
                strong = StrongRelease if positive else WeakUntil
                return strong(go(left, positive), go(right, positive))

    def same(left: Formula, right: Formula, positive: bool) -> Formula:
        both = conjunction((go(left, True), go(right, positive)))
        neither = conjunction((go(left, False), go(right, not positive)))
        return disjunction((both, neither))

    return go(formula, True)
