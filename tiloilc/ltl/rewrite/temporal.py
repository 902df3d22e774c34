"""Rules for X, F, G, U, W, R and M. Each comes with its dual."""

from __future__ import annotations

from collections.abc import Callable

from tiloilc.ltl.ast import (
    FALSE,
    TRUE,
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
    conjunction,
    disjunction,
)
from tiloilc.ltl.fragments import is_eventual, is_suspendable, is_universal
from tiloilc.ltl.rewrite.implication import covers, excludes, implies


def constants(f: Formula) -> Formula:
    """`F true` to `true`, `a U false` to `false`, `true U a` to `F a`, and so on."""
    match f:
        case Next(Constant() as a) | Eventually(Constant() as a) | Always(Constant() as a):
            return a
        case Until(a, Constant() as b):
            return b
        case WeakUntil(a, Constant(value)):
            return TRUE if value else Always(a)
        case Release(a, Constant() as b):
            return b
        case StrongRelease(a, Constant(value)):
            return Eventually(a) if value else FALSE
        case Until(Constant(value), b):
            return Eventually(b) if value else b
        case WeakUntil(Constant(value), b):
            return TRUE if value else b
        case Release(Constant(value), b):
            return b if value else Always(b)
        case StrongRelease(Constant(value), b):
            return b if value else FALSE
    return f


def idempotence(f: Formula) -> Formula:
    """`F F a` to `F a`, `F G F a` to `G F a`, `X G F a` to `G F a`: time changes nothing here."""
    match f:
        case Eventually(a) if is_eventual(a):
            return a
        case Always(a) if is_universal(a):
            return a
        case Next(a) if is_suspendable(a):
            return a
    return f


def next_outwards(f: Formula) -> Formula:
    """`F X a` to `X F a`, `X a U X b` to `X (a U b)`."""
    match f:
        case Eventually(Next(a)):
            return Next(Eventually(a))
        case Always(Next(a)):
            return Next(Always(a))
        case (
            Until(Next(a), Next(b))
            | WeakUntil(Next(a), Next(b))
            | Release(Next(a), Next(b))
            | StrongRelease(Next(a), Next(b))
        ):
            return Next(type(f)(a, b))
    return f


def eventually_inwards(f: Formula) -> Formula:
    """`F (a U b)` to `F b`, `F (a & G F b)` to `F a & G F b`, `F (a | G b)` to `F a | F G b`."""
    match f:
        case Eventually(Until(_, b)):
            return Eventually(b)
        case Eventually(StrongRelease(a, b)):
            return Eventually(conjunction((a, b)))
        case Eventually(WeakUntil(a, b)):
            return disjunction((Eventually(b), Eventually(Always(a))))
        case Eventually(Release(a, b)):
            return disjunction((Eventually(conjunction((a, b))), Eventually(Always(b))))
        case Eventually(And(operands)):
            return conjunction(_distributed(operands, Eventually, is_suspendable, conjunction))
        case Eventually(Or(operands)):
            return disjunction(_distributed(operands, Eventually, _is_special, disjunction))
    return f


def always_inwards(f: Formula) -> Formula:
    """`G (a R b)` to `G b`, `G (a | F G b)` to `G a | F G b`, `G (a & F b)` to `G a & G F b`."""
    match f:
        case Always(Release(_, b)):
            return Always(b)
        case Always(WeakUntil(a, b)):
            return Always(disjunction((a, b)))
        case Always(StrongRelease(a, b)):
            return conjunction((Always(b), Always(Eventually(a))))
        case Always(Until(a, b)):
            return conjunction((Always(disjunction((a, b))), Always(Eventually(b))))
        case Always(Or(operands)):
            return disjunction(_distributed(operands, Always, is_suspendable, disjunction))
        case Always(And(operands)):
            return conjunction(_distributed(operands, Always, _is_special, conjunction))
    return f


def degenerate(f: Formula) -> Formula:
    """`a U b` to `b` if a implies b, to `F b` if one of them always holds; W, R, M alike."""
    match f:
        case Until(a, b) | WeakUntil(a, b) if implies(a, b):
            return b
        case Release(a, b) | StrongRelease(a, b) if implies(b, a):
            return b
        case Until(a, b) if covers(a, b):
            return Eventually(b)
        case WeakUntil(a, b) if covers(a, b):
            return TRUE
        case Release(a, b) if excludes(a, b):
            return Always(b)
        case StrongRelease(a, b) if excludes(a, b):
            return FALSE
    return f


def lasting(f: Formula) -> Formula:
    """`a U F b` to `F b`, `G a W b` to `G a | b`: operands that time does not take back."""
    match f:
        case Until(_, b) if is_eventual(b):
            return b
        case WeakUntil(a, b) if is_eventual(b):
            return disjunction((b, Always(a)))
        case Release(_, b) if is_universal(b):
            return b
        case StrongRelease(a, b) if is_universal(b):
            return conjunction((b, Eventually(a)))
        case WeakUntil(a, b) if is_universal(a):
            return disjunction((a, b))
        case Until(a, b) if is_universal(a):
            return disjunction((b, conjunction((a, Eventually(b)))))
        case StrongRelease(a, b) if is_eventual(a):
            return conjunction((a, b))
        case Release(a, b) if is_eventual(a):
            return conjunction((b, disjunction((a, Always(b)))))
    return f


def nested(f: Formula) -> Formula:
    """`a U (a U b)` and `(a U b) U b` to `a U b`; W, R and M alike."""
    match f:
        case Until(a, Until(c, _) | WeakUntil(c, _) as inner) if implies(a, c):
            return inner
        case WeakUntil(a, WeakUntil(c, _) as inner) if implies(a, c):
            return inner
        case WeakUntil(a, Until(c, b)) if a == c:
            return WeakUntil(a, b)
        case Release(a, Release(c, _) | StrongRelease(c, _) as inner) if implies(c, a):
            return inner
        case StrongRelease(a, StrongRelease(c, _) as inner) if implies(c, a):
            return inner
        case StrongRelease(a, Release(c, b)) if a == c:
            return StrongRelease(a, b)
        case Until(Until(a, c) | WeakUntil(a, c), b) if b == c:
            return Until(a, b)
        case WeakUntil(WeakUntil(a, c), b) if b == c:
            return WeakUntil(a, b)
        case Release(Release(a, c) | StrongRelease(a, c), b) if b == c:
            return Release(a, b)
        case StrongRelease(StrongRelease(a, c), b) if b == c:
            return StrongRelease(a, b)
        case Until(Until(c, a) | WeakUntil(c, a), b) | WeakUntil(Until(c, a) | WeakUntil(c, a), b):
            return type(f)(a, b) if implies(c, b) else f
        case Release(Release(c, a) | StrongRelease(c, a), b) | StrongRelease(
            Release(c, a) | StrongRelease(c, a), b
        ):
            return type(f)(a, b) if implies(b, c) else f
    return f


def release_by(f: Formula) -> Formula:
    """`a U (a & b)` to `b M a`, `a R (a | b)` to `b W a`; W and M alike."""
    match f:
        case Until(a, And(operands)) if a in operands:
            return StrongRelease(conjunction([o for o in operands if o != a]), a)
        case WeakUntil(a, And(operands)) if a in operands:
            return Release(conjunction([o for o in operands if o != a]), a)
        case Release(a, Or(operands)) if a in operands:
            return WeakUntil(disjunction([o for o in operands if o != a]), a)
        case StrongRelease(a, Or(operands)) if a in operands:
            return Until(disjunction([o for o in operands if o != a]), a)
    return f


def suspendable_outwards(f: Formula) -> Formula:
    """`a U (b & G F c)` to `(a U b) & G F c`, `a R (b | F G c)` to `(a R b) | F G c`."""
    match f:
        case Until(a, And(operands)) | Release(a, And(operands)) | StrongRelease(a, And(operands)):
            join = conjunction
        case Until(a, Or(operands)) | WeakUntil(a, Or(operands)) | Release(a, Or(operands)):
            join = disjunction
        case _:
            return f
    inside = [operand for operand in operands if not is_suspendable(operand)]
    if len(inside) == len(operands):
        return f
    outside = [operand for operand in operands if is_suspendable(operand)]
    return join([type(f)(a, join(inside)), *outside])


def in_the_limit(f: Formula) -> Formula:
    """`G F (a | X b)` to `G F (a | b)`, `G F (a & G b)` to `G F a & F G b`, and duals."""
    match f:
        case Always(Eventually(Or(operands))) if any(isinstance(o, Next) for o in operands):
            return Always(Eventually(disjunction(map(_now, operands))))
        case Eventually(Always(And(operands))) if any(isinstance(o, Next) for o in operands):
            return Eventually(Always(conjunction(map(_now, operands))))
        case Always(Eventually(And(operands))) if any(map(is_universal, operands)):
            lasting = [Eventually(o) for o in operands if is_universal(o)]
            rest = conjunction([o for o in operands if not is_universal(o)])
            return conjunction([Always(Eventually(rest)), *lasting])
        case Eventually(Always(Or(operands))) if any(map(is_eventual, operands)):
            often = [Always(o) for o in operands if is_eventual(o)]
            rest = disjunction([o for o in operands if not is_eventual(o)])
            return disjunction([Eventually(Always(rest)), *often])
    return f


def _now(operand: Formula) -> Formula:
    """The operand without X: one step does not matter."""
    return operand.operand if isinstance(operand, Next) else operand


def _is_special(operand: Formula) -> bool:
    return is_eventual(operand) or is_universal(operand)


def _distributed(
    operands: tuple[Formula, ...],
    operator: Callable[[Formula], Formula],
    apart: Callable[[Formula], bool],
    join: Callable[[list[Formula]], Formula],
) -> list[Formula]:
    """`operator` on every operand that can be taken `apart`, and once on the rest together."""
    rest = [operand for operand in operands if not apart(operand)]
    parts: dict[Formula, None] = {}
    for operand in operands:
        parts.setdefault(operator(operand if apart(operand) else join(rest)))
    return list(parts)
