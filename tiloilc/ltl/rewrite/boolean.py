"""Rules for & and |. Each comes with its dual; operands keep the written order.

Normal forms are flat and without constants and repetitions: `conjunction` and `disjunction` see to
it, so no rule need.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

from tiloilc.ltl.ast import (
    FALSE,
    TRUE,
    Always,
    And,
    Eventually,
    Formula,
    Next,
    Or,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    conjunction,
    disjunction,
)
from tiloilc.ltl.fragments import is_eventual, is_suspendable, is_universal
from tiloilc.ltl.rewrite.implication import covers, excludes, implies, negated


def contradiction(f: Formula) -> Formula:
    """`a & !a` to `false`, `F a | G !a` to `true`: two operands exclude or complete each other."""
    match f:
        case And(operands) if _some_pair(operands, excludes):
            return FALSE
        case Or(operands) if _some_pair(operands, covers):
            return TRUE
    return f


def absorption(f: Formula) -> Formula:
    """`a & F a` to `a`, `a | F a` to `F a`: operands that others imply say nothing."""
    match f:
        case And(operands):
            return conjunction(_strongest(operands))
        case Or(operands):
            weakest = _strongest([negated(operand) for operand in operands])
            return disjunction([o for o in operands if negated(o) in weakest])
    return f


def unit(f: Formula) -> Formula:
    """`a & (!a | b)` to `a & b`, `a & (a & b | c)` to `a & (b | c)`: in the light of the others."""
    match f:
        case And(operands):
            return conjunction(_relative(operands))
        case Or(operands):
            return disjunction([negated(o) for o in _relative([negated(o) for o in operands])])
    return f


def join_next(f: Formula) -> Formula:
    """`X a & X b` to `X (a & b)`, with suspendable operands, which time does not change."""

    def inner(operand: Formula) -> Formula | None:
        if isinstance(operand, Next):
            return operand.operand
        return operand if is_suspendable(operand) else None

    if isinstance(f, And | Or) and any(isinstance(o, Next) for o in f.operands):
        return _gathered(f, inner, Next)
    return f


def join_eventually(f: Formula) -> Formula:
    """`F a | F b` to `F (a | b)`; `F G a` stays: a suspendable formula is worth more alone."""

    def inner(operand: Formula) -> Formula | None:
        match operand:
            case Eventually(a) if not is_universal(a):
                return a
        return None

    return _gathered(f, inner, Eventually) if isinstance(f, Or) else f


def join_always(f: Formula) -> Formula:
    """`G a & G b` to `G (a & b)`; `G F a` stays: a suspendable formula is worth more alone."""

    def inner(operand: Formula) -> Formula | None:
        match operand:
            case Always(a) if not is_eventual(a):
                return a
        return None

    return _gathered(f, inner, Always) if isinstance(f, And) else f


def join_suspendable(f: Formula) -> Formula:
    """`G F a | G F b` to `G F (a | b)`, `F G a & F G b` to `F G (a & b)`."""

    def often(operand: Formula) -> Formula | None:
        match operand:
            case Always(Eventually(a)):
                return a
        return None

    def lasting(operand: Formula) -> Formula | None:
        match operand:
            case Eventually(Always(a)):
                return a
        return None

    match f:
        case Or():
            return _gathered(f, often, lambda a: Always(Eventually(a)))
        case And():
            return _gathered(f, lasting, lambda a: Eventually(Always(a)))
    return f


def join_until(f: Formula) -> Formula:
    """`(a U b) | (a U c)` to `a U (b | c)`, `(a U b) & (c U b)` to `(a & c) U b`; W, R, M alike."""
    if not isinstance(f, And | Or):
        return f
    join = conjunction if isinstance(f, And) else disjunction
    weak_first = (Until, WeakUntil), (Release, StrongRelease)
    by_right, by_left = weak_first if isinstance(f, And) else reversed(weak_first)
    for one, other in combinations(f.operands, 2):
        if type(one) is not type(other):
            continue
        if isinstance(one, by_left) and isinstance(other, by_left) and one.left == other.left:
            both = type(one)(one.left, join((one.right, other.right)))
            return _merged(f, one, other, both)
        if isinstance(one, by_right) and isinstance(other, by_right) and one.right == other.right:
            both = type(one)(join((one.left, other.left)), one.right)
            return _merged(f, one, other, both)
    return f


def beside_lasting(f: Formula) -> Formula:
    """`G a & (a U b)` to `G a & F b`, `F a | (a R b)` to `F a | G b`; M and W alike."""
    match f:
        case And(operands):
            always = [o.operand for o in operands if isinstance(o, Always)]
            return conjunction([_beside_always(o, always) for o in operands])
        case Or(operands):
            eventually = [o.operand for o in operands if isinstance(o, Eventually)]
            return disjunction([_beside_eventually(o, eventually) for o in operands])
    return f


def _beside_always(operand: Formula, always: Sequence[Formula]) -> Formula:
    match operand:
        case Until(a, b) | StrongRelease(b, a) if any(implies(c, a) for c in always):
            return Eventually(b)
    return operand


def _beside_eventually(operand: Formula, eventually: Sequence[Formula]) -> Formula:
    match operand:
        case Release(a, b) | WeakUntil(b, a) if any(implies(a, c) for c in eventually):
            return Always(b)
    return operand


def combine(f: Formula) -> Formula:
    """`(a U b) | G a` to `a W b`, `(a W b) & F b` to `a U b`, and R and M alike."""
    if not isinstance(f, And | Or):
        return f
    for one in f.operands:
        for other in f.operands:
            match f, one, other:
                case Or(), Until(a, b), Always(c) if a == c:
                    return _merged(f, one, other, WeakUntil(a, b))
                case Or(), StrongRelease(a, b), Always(c) if b == c:
                    return _merged(f, one, other, Release(a, b))
                case And(), WeakUntil(a, b), Eventually(c) if b == c:
                    return _merged(f, one, other, Until(a, b))
                case And(), Release(a, b), Eventually(c) if a == c:
                    return _merged(f, one, other, StrongRelease(a, b))
    return f


def refold(f: Formula) -> Formula:
    """`a | X F a` to `F a`, `b | (a & X (a U b))` to `a U b`: expansion laws, backwards."""
    if not isinstance(f, And | Or):
        return f
    for one in f.operands:
        for other in f.operands:
            match f, other:
                case Or(), Next(Eventually(a) as whole) if a == one:
                    return _merged(f, one, other, whole)
                case And(), Next(Always(a) as whole) if a == one:
                    return _merged(f, one, other, whole)
                case Or(), And((a, Next(Until(c, b) | WeakUntil(c, b) as whole))) if (
                    a == c and b == one
                ):
                    return _merged(f, one, other, whole)
                case And(), Or((a, Next(Release(c, b) | StrongRelease(c, b) as whole))) if (
                    a == c and b == one
                ):
                    return _merged(f, one, other, whole)
    return f


def _some_pair(operands: Sequence[Formula], related: Callable[[Formula, Formula], bool]) -> bool:
    return any(related(one, other) for one, other in combinations(operands, 2))


def _strongest(operands: Sequence[Formula]) -> list[Formula]:
    """The operands without those that another one implies; of equivalent ones the first."""
    kept = list(operands)
    for operand in reversed(operands):
        if any(other is not operand and implies(other, operand) for other in kept):
            kept = [other for other in kept if other is not operand]
    return kept


def _relative(operands: Sequence[Formula]) -> list[Formula]:
    """The conjuncts without what others rule out or say already; one by one, to be sound."""
    kept = list(operands)
    for place, operand in enumerate(kept):
        if isinstance(operand, Or):
            others = kept[:place] + kept[place + 1 :]
            cases = [c for c in operand.operands if not any(excludes(c, o) for o in others)]
            kept[place] = disjunction([_without_implied(case, others) for case in cases])
    return kept


def _without_implied(case: Formula, others: Sequence[Formula]) -> Formula:
    if not isinstance(case, And):
        return case
    return conjunction([c for c in case.operands if not any(implies(o, c) for o in others)])


def _gathered(
    f: And | Or,
    inner: Callable[[Formula], Formula | None],
    operator: Callable[[Formula], Formula],
) -> Formula:
    """`f` with the operands of which `inner` knows the core under one `operator`, first's place."""
    cores = [core for o in f.operands if (core := inner(o)) is not None]
    if len(cores) < 2:
        return f
    join = conjunction if isinstance(f, And) else disjunction
    joined = operator(join(cores))
    return join([o if inner(o) is None else joined for o in f.operands])


def _merged(f: And | Or, one: Formula, other: Formula, both: Formula) -> Formula:
    """`f` with `both` in the place of its operands `one` and `other`."""
    join = conjunction if isinstance(f, And) else disjunction
    return join([both if o is one or o is other else o for o in f.operands])
