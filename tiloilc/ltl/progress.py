"""Progression: what is left to satisfy after a letter.

Esparza, Křetínský and Sickert, One Theorem to Rule Them All (LICS 2018), section 4.
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet

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
    subformulas,
)


def unfold(formula: Formula) -> Formula:
    """The expansion laws, applied outside every X: `F a` becomes `a | X F a`. NNF in, NNF out."""
    done: dict[Formula, Formula] = {}
    for part in subformulas(formula):
        done[part] = _expand(part, done, Next(part))
    return done[formula]


def after(formula: Formula, letter: AbstractSet[str]) -> Formula:
    """af(formula, letter): a word w satisfies it just if letter · w satisfies `formula`.

    `formula` in negation normal form; `letter` names the propositions that hold.
    """
    done: dict[Formula, Formula] = {}
    for part in subformulas(formula):
        match part:
            case Proposition(name):
                done[part] = Constant(name in letter)
            case Not(Proposition(name)):
                done[part] = Constant(name not in letter)
            case Next(operand):
                done[part] = operand
            case _:
                done[part] = _expand(part, done, part)
    return done[formula]


def _expand(part: Formula, done: dict[Formula, Formula], later: Formula) -> Formula:
    """The expansion law of `part`: its operands as in `done` now, `later` for itself later."""
    match part:
        case And(operands):
            return conjunction([done[operand] for operand in operands])
        case Or(operands):
            return disjunction([done[operand] for operand in operands])
        case Eventually(operand):
            return disjunction((done[operand], later))
        case Always(operand):
            return conjunction((done[operand], later))
        case Until(left, right) | WeakUntil(left, right):
            return disjunction((done[right], conjunction((done[left], later))))
        case Release(left, right) | StrongRelease(left, right):
            return conjunction((done[right], disjunction((done[left], later))))
        case Constant() | Proposition() | Not(Proposition()) | Next():
            return part
    raise AssertionError(f"not in negation normal form: {part!r}")
