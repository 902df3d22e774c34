"""Negation normal form: negation stands before propositions only."""

from __future__ import annotations

from tiloilc.ltl.ast import (
    FALSE,
    TRUE,
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
    subformulas,
)


def nnf(formula: Formula) -> Formula:
    """`formula` without ->, <-> and xor, and with negation on propositions only.

    F, G, U, W, R, M, X are kept; junctions come out flat and in the written order. Equal parts of
    the result are one object, so that a tower of <-> takes linear space.
    """
    return _both_signs(formula)[0]


def negation(formula: Formula) -> Formula:
    """The negation normal form of `!formula`."""
    return _both_signs(formula)[1]


def _both_signs(formula: Formula) -> tuple[Formula, Formula]:
    """The normal forms of `formula` and of its negation."""
    signed: dict[Formula, tuple[Formula, Formula]] = {}
    for part in subformulas(formula):
        operands = [signed[child] for child in part.children]
        signed[part] = _positive(part, operands), _negative(part, operands)
    return signed[formula]


def _positive(part: Formula, operands: list[tuple[Formula, Formula]]) -> Formula:
    """`part` over normal forms (of the operand, of its negation)."""
    match part:
        case Constant() | Proposition():
            return part
        case Not():
            return operands[0][1]
        case And():
            return conjunction([yes for yes, _ in operands])
        case Or():
            return disjunction([yes for yes, _ in operands])
        case Next() | Eventually() | Always():
            return type(part)(operands[0][0])
        case Until() | WeakUntil() | Release() | StrongRelease():
            return type(part)(operands[0][0], operands[1][0])
    (left, not_left), (right, not_right) = operands
    match part:
        case Implies():
            return disjunction((not_left, right))
        case Iff():
            return disjunction((conjunction((left, right)), conjunction((not_left, not_right))))
        case Xor():
            return disjunction((conjunction((left, not_right)), conjunction((not_left, right))))
    raise AssertionError(f"not an operator: {part!r}")


def _negative(part: Formula, operands: list[tuple[Formula, Formula]]) -> Formula:
    """The negation of `part` over normal forms (of the operand, of its negation)."""
    match part:
        case Constant(value):
            return FALSE if value else TRUE
        case Proposition():
            return Not(part)
        case Not():
            return operands[0][0]
        case And():
            return disjunction([no for _, no in operands])
        case Or():
            return conjunction([no for _, no in operands])
        case Next():
            return Next(operands[0][1])
        case Eventually():
            return Always(operands[0][1])
        case Always():
            return Eventually(operands[0][1])
    (left, not_left), (right, not_right) = operands
    match part:
        case Until():
            return Release(not_left, not_right)
        case Release():
            return Until(not_left, not_right)
        case WeakUntil():
            return StrongRelease(not_left, not_right)
        case StrongRelease():
            return WeakUntil(not_left, not_right)
        case Implies():
            return conjunction((left, not_right))
        case Iff():
            return disjunction((conjunction((left, not_right)), conjunction((not_left, right))))
        case Xor():
            return disjunction((conjunction((left, right)), conjunction((not_left, not_right))))
    raise AssertionError(f"not an operator: {part!r}")
