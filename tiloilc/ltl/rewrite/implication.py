"""Implication between formulas as far as the syntax shows it: sound, not complete."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from tiloilc.ltl.ast import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
)
from tiloilc.ltl.fragments import REMEMBERED, is_eventual, is_universal, remembered
from tiloilc.ltl.normal import negation

MAX_HEIGHT = 100
"""Both heights together: beyond, nothing is found, so that recursion stays shallow."""


def implies(stronger: Formula, weaker: Formula) -> bool:
    """Whether `stronger -> weaker` is seen to be valid. Both in negation normal form."""
    return height(stronger) + height(weaker) <= MAX_HEIGHT and _implies(stronger, weaker)


def excludes(one: Formula, other: Formula) -> bool:
    """Whether `one & other` is seen to be unsatisfiable. Both in negation normal form."""
    return implies(one, negated(other)) or implies(other, negated(one))


def covers(one: Formula, other: Formula) -> bool:
    """Whether `one | other` is seen to be valid. Both in negation normal form."""
    return implies(negated(one), other) or implies(negated(other), one)


@lru_cache(maxsize=REMEMBERED)
def negated(formula: Formula) -> Formula:
    """`negation`, remembered."""
    return negation(formula)


@remembered
def height(formula: Formula, again: Callable[[Formula], int]) -> int:
    """Operators on the longest way down."""
    return 1 + max([again(child) for child in formula.children], default=-1)


@lru_cache(maxsize=REMEMBERED)
def _implies(f: Formula, g: Formula) -> bool:
    if f == g:
        return True
    if isinstance(f, Constant) or isinstance(g, Constant):
        return f == Constant(False) or g == Constant(True)
    if isinstance(g, And):
        return all(_implies(f, part) for part in g.operands)
    if isinstance(f, Or):
        return all(_implies(part, g) for part in f.operands)
    if isinstance(g, Or) and any(_implies(f, part) for part in g.operands):
        return True
    if isinstance(f, And) and any(_implies(part, g) for part in f.operands):
        return True
    return _by_operator(f, g) or _from_stronger(f, g) or _to_weaker(f, g)


def _by_operator(f: Formula, g: Formula) -> bool:
    """Monotonicity: operators of one kind, operand by operand."""
    match f, g:
        case Next(a), Next(b):
            return _implies(a, b)
        case (Until(a, b), Until(c, d) | WeakUntil(c, d)) | (WeakUntil(a, b), WeakUntil(c, d)):
            return _implies(a, c) and _implies(b, d)
        case (StrongRelease(a, b), StrongRelease(c, d) | Release(c, d)) | (
            Release(a, b),
            Release(c, d),
        ):
            return _implies(a, c) and _implies(b, d)
        case StrongRelease(a, b), Until(c, d) | WeakUntil(c, d):
            return _implies(b, c) and (_implies(a, d) or _implies(b, d))
    return False


def _from_stronger(f: Formula, g: Formula) -> bool:
    """What `f` implies at the first position, or at some position if that is enough for `g`."""
    match f:
        case Always(a):
            return _implies(a, g)
        case Eventually(a):
            return is_eventual(g) and _implies(a, g)
        case Next(a):
            return is_eventual(g) and _implies(a, g)
        case Until(a, b):
            return _implies(b, g) and (is_eventual(g) or _implies(a, g))
        case WeakUntil(a, b):
            return _implies(a, g) and _implies(b, g)
        case Release(_, b):
            return _implies(b, g)
        case StrongRelease(a, b):
            return _implies(b, g) or (is_eventual(g) and _implies(a, g))
    return False


def _to_weaker(f: Formula, g: Formula) -> bool:
    """What is enough for `g` at the first position, or for ever if `f` lasts."""
    match g:
        case Eventually(c):
            return _implies(f, c)
        case Always(c):
            return is_universal(f) and _implies(f, c)
        case Next(c):
            return is_universal(f) and _implies(f, c)
        case Until(_, d):
            return _implies(f, d)
        case WeakUntil(c, d):
            return _implies(f, d) or (is_universal(f) and _implies(f, c))
        case Release(c, d):
            return _implies(f, d) and (is_universal(f) or _implies(f, c))
        case StrongRelease(c, d):
            return _implies(f, c) and _implies(f, d)
    return False
