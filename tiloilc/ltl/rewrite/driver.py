"""Simplification: small rules, in one visible order, until none of them changes anything."""

from __future__ import annotations

from collections.abc import Callable
from operator import is_

from tiloilc.ltl.ast import (
    And,
    Binary,
    Formula,
    Or,
    Unary,
    conjunction,
    disjunction,
    subformulas,
)
from tiloilc.ltl.normal import nnf
from tiloilc.ltl.rewrite import boolean, temporal

Rule = Callable[[Formula], Formula]

RULES: tuple[Rule, ...] = (
    temporal.constants,
    temporal.idempotence,
    temporal.next_outwards,
    temporal.eventually_inwards,
    temporal.always_inwards,
    temporal.degenerate,
    temporal.lasting,
    temporal.nested,
    temporal.release_by,
    temporal.suspendable_outwards,
    temporal.in_the_limit,
    boolean.contradiction,
    boolean.absorption,
    boolean.unit,
    boolean.join_next,
    boolean.join_eventually,
    boolean.join_always,
    boolean.join_suspendable,
    boolean.join_until,
    boolean.beside_lasting,
    boolean.combine,
    boolean.refold,
)
"""Each takes a formula in normal form to an equivalent one, by its root; most leave it as it is.

None touches the order in `G F (a & X F b)`: it is not in the language, but in the demonstrations.
"""

MAX_ROUNDS = 50
"""Formulas settle in a few rounds; stopping early is never wrong, only less simple."""

MAX_SIZE = 2_000
"""Operators and leaves. Larger normal forms (towers of <->) stay as they are: rules would crawl."""


def simplify(formula: Formula) -> Formula:
    """A simpler equivalent of `formula`, in negation normal form."""
    current = nnf(formula)
    if _size(current) > MAX_SIZE:
        return current
    for _ in range(MAX_ROUNDS):
        following = _round(current)
        if following == current:
            break
        current = following
    return current


def _round(formula: Formula) -> Formula:
    """Every part of `formula` once by all rules, operands first."""
    done: dict[Formula, Formula] = {}
    for part in subformulas(formula):
        done[part] = _by_rules(_over(part, [done[child] for child in part.children]))
    return done[formula]


def _by_rules(part: Formula) -> Formula:
    for rule in RULES:
        changed = rule(part)
        if changed != part:  # else keep the object itself: equal objects compare fast
            part = changed
    return part


def _size(formula: Formula) -> int:
    """Operators and leaves of the tree, shared parts counted as often as they appear."""
    size: dict[Formula, int] = {}
    for part in subformulas(formula):
        size[part] = 1 + sum(size[child] for child in part.children)
    return size[formula]


def _over(part: Formula, operands: list[Formula]) -> Formula:
    """The operator of `part` over other operands."""
    if all(map(is_, operands, part.children)):
        return part
    match part:
        case And():
            return conjunction(operands)
        case Or():
            return disjunction(operands)
        case Unary() | Binary():
            return type(part)(*operands)
    return part
