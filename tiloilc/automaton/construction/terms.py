"""Formulas as numbered terms: an operator over earlier terms, stored once.

Equality is equality of numbers. The constructors know the laws that hold whatever the operands
are, so that the construction never meets `F F a` or `X G F a`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NewType

from tiloilc.automaton.limits import Budget
from tiloilc.ltl import ast, nnf
from tiloilc.ltl.ast import Formula, subformulas

Term = NewType("Term", int)
"""A formula, as a place in its table."""

NO = Term(0)
YES = Term(1)

LEAST = frozenset("FUM")
"""µ-operators: what they promise must come."""

GREATEST = frozenset("GWR")
"""ν-operators: what they promise may never be broken."""

_UNARY: dict[str, type[ast.Next] | type[ast.Eventually] | type[ast.Always]] = {
    "X": ast.Next,
    "F": ast.Eventually,
    "G": ast.Always,
}
_BINARY: dict[
    str, type[ast.Until] | type[ast.WeakUntil] | type[ast.Release] | type[ast.StrongRelease]
] = {"U": ast.Until, "W": ast.WeakUntil, "R": ast.Release, "M": ast.StrongRelease}
_LETTER_OF: dict[type[object], str] = {
    **{kind: letter for letter, kind in _UNARY.items()},
    **{kind: letter for letter, kind in _BINARY.items()},
}


class Terms:
    """The terms of one translation. Every list is indexed by term.

    `choices`: GF p | GF q stays a choice between two goals, where it could be one goal p | q.
    """

    def __init__(self, propositions: Sequence[str], budget: Budget, choices: bool = False) -> None:
        self._choices = choices
        self.propositions = tuple(propositions)
        self.budget = budget
        self.operator: list[str] = []
        self.operands: list[tuple[Term, ...]] = []
        self.has_least: list[bool] = []
        self.has_greatest: list[bool] = []
        self.recurrence: list[bool] = []
        self.eventual: list[bool] = []
        self.universal: list[bool] = []
        self._index: dict[tuple[str, tuple[Term, ...]], Term] = {}
        self._add("false", ())
        self._add("true", ())

    def __iter__(self) -> Iterator[Term]:
        """All terms so far."""
        return map(Term, range(len(self.operator)))

    def _add(self, operator: str, operands: tuple[Term, ...]) -> Term:
        key = (operator, operands)
        found = self._index.get(key)
        if found is not None:
            return found
        self.budget.tick()
        term = self._index[key] = Term(len(self.operator))
        least, greatest = operator in LEAST, operator in GREATEST
        below_greatest = any(self.has_greatest[t] for t in operands)
        constant = operator in ("true", "false")
        inner = operator in ("and", "or", "X")
        last = operands[-1:]
        self.operator.append(operator)
        self.operands.append(operands)
        self.has_least.append(least or any(self.has_least[t] for t in operands))
        self.has_greatest.append(greatest or below_greatest)
        self.recurrence.append(
            all(self.recurrence[t] for t in operands) and not (least and below_greatest)
        )
        self.eventual.append(
            constant
            or operator == "F"
            or ((inner or operator == "G") and all(self.eventual[t] for t in operands))
            or (operator == "U" and all(self.eventual[t] for t in last))
        )
        self.universal.append(
            constant
            or operator == "G"
            or ((inner or operator == "F") and all(self.universal[t] for t in operands))
            or (operator == "R" and all(self.universal[t] for t in last))
        )
        return term

    def of(self, formula: Formula) -> Term:
        """The term of `formula`, whose propositions are all known."""
        done: dict[Formula, Term] = {}
        formula = nnf(formula)
        for part in subformulas(formula):
            operands = [done[child] for child in part.children]
            match part:
                case ast.Constant(value):
                    done[part] = YES if value else NO
                case ast.Proposition(name):
                    done[part] = self.literal(self.propositions.index(name), True)
                case ast.Not(ast.Proposition(name)):
                    done[part] = self.literal(self.propositions.index(name), False)
                case ast.And():
                    done[part] = self.both(operands)
                case ast.Or():
                    done[part] = self.either(operands)
                case _:
                    done[part] = self.make(_LETTER_OF[type(part)], *operands)
        return done[formula]

    def literal(self, proposition: int, sign: bool) -> Term:
        """A proposition, or its negation."""
        return self._add(f"{'+' if sign else '-'}{proposition}", ())

    def opposite(self, literal: Term) -> Term:
        """The negation of a literal."""
        name = self.operator[literal]
        return self.literal(int(name[1:]), name[0] == "-")

    def both(self, operands: Sequence[Term]) -> Term:
        """Conjunction: flat, without repetitions, in the given order."""
        return self._junction("and", operands, YES, NO)

    def either(self, operands: Sequence[Term]) -> Term:
        """Disjunction: flat, without repetitions, in the given order."""
        return self._junction("or", operands, NO, YES)

    def _junction(
        self, name: str, operands: Sequence[Term], neutral: Term, absorbing: Term
    ) -> Term:
        parts: dict[Term, None] = {}
        for operand in operands:
            flat = self.operands[operand] if self.operator[operand] == name else (operand,)
            parts.update(dict.fromkeys(flat))
        parts.pop(neutral, None)
        if absorbing in parts:
            return absorbing
        for part in parts:
            sign = self.operator[part]
            if sign[0] == "+" and self._index.get((f"-{sign[1:]}", ())) in parts:
                return absorbing
        lasting = [t for t in parts if self._merges(name, t)]
        if len(lasting) > 1:
            parts = dict.fromkeys(lasting[0] if t in lasting else t for t in parts)
            inner = [self.operands[self.operands[t][0]][0] for t in lasting]
            outer, under = ("F", "G") if name == "and" else ("G", "F")
            merged = self._unary(
                outer, self._unary(under, self._junction(name, inner, neutral, absorbing))
            )
            return self._junction(
                name, [merged if t == lasting[0] else t for t in parts], neutral, absorbing
            )
        if len(parts) < 2:
            return next(iter(parts), neutral)
        return self._add(name, tuple(parts))

    def _merges(self, junction: str, term: Term) -> bool:
        """Whether FG p & FG q, or GF p | GF q, may be one term.

        Goals only where they take a bounded number of letters: longer ones go their own ways.
        """
        if junction == "or":
            goal = None if self._choices else self.goal(term)
            return goal is not None and not self.has_least[goal]
        inner = self.operands[term][:1]
        return self.operator[term] == "F" and [self.operator[t] for t in inner] == ["G"]

    def suspendable(self, term: Term) -> bool:
        """Whether the truth of `term` on a word never changes as the word goes on."""
        return self.eventual[term] and self.universal[term]

    def comes_to_stay(self, term: Term) -> bool:
        """Whether `term` is an F p or X p that is p from some place on, as F G a is G a."""
        return self.operator[term] in ("F", "X") and self.universal[self.operands[term][0]]

    def make(self, operator: str, *operands: Term) -> Term:
        """A temporal operator over `operands`."""
        if operator in ("F", "G", "X"):
            return self._unary(operator, operands[0])
        return self._binary(operator, *operands)

    def rebuild(self, name: str, operands: Sequence[Term]) -> Term:
        """The operator `name`, temporal or Boolean, over `operands`."""
        if name in ("and", "or"):
            return self.both(operands) if name == "and" else self.either(operands)
        return self.make(name, *operands)

    def _unary(self, operator: str, operand: Term) -> Term:
        same = {"F": self.eventual, "G": self.universal}
        if self.suspendable(operand) or (operator != "X" and same[operator][operand]):
            return operand
        name, inner = self.operator[operand], self.operands[operand]
        if operator != "X" and name == "X":
            return self._unary("X", self._unary(operator, inner[0]))
        if name in ("and", "or"):
            junction = self.both if name == "and" else self.either
            fixed = [t for t in inner if self._apart(operator, name, t)]
            if fixed:
                apart = [self._unary(operator, t) for t in fixed]
                rest = junction([t for t in inner if t not in fixed])
                return junction([self._unary(operator, rest), *apart])
        if len(inner) == 2 and name not in ("and", "or"):
            return self._over_binary(operator, name, *inner)
        return self._add(operator, (operand,))

    def _apart(self, operator: str, junction: str, term: Term) -> bool:
        """Whether `operator` over a junction may be taken to its part `term` alone."""
        if operator + junction == "Gand":
            return self.eventual[term] or self.has_least[term]
        if operator + junction == "For":
            return self.universal[term]
        return self.suspendable(term)

    def _over_binary(self, operator: str, inner: str, left: Term, right: Term) -> Term:
        """F, G or X of a binary operator: always and eventually need no "until"."""
        always, eventually = partial(self._unary, "G"), partial(self._unary, "F")
        match operator + inner:
            case "FU":
                return eventually(right)
            case "FM":
                return eventually(self.both([left, right]))
            case "FW":
                return self.either([eventually(right), eventually(always(left))])
            case "FR":
                parts = [eventually(self.both([left, right])), eventually(always(right))]
                return self.either(parts)
            case "GR":
                return always(right)
            case "GW":
                return always(self.either([left, right]))
            case "GU":
                return self.both([always(self.either([left, right])), always(eventually(right))])
            case "GM":
                return self.both([always(right), always(eventually(left))])
        return self._add(operator, (self._index[inner, (left, right)],))

    def _binary(self, operator: str, left: Term, right: Term) -> Term:
        if right in (NO, YES) or self.suspendable(right) or left == right:
            if operator in ("U", "R") or left == right:
                return right
            if operator == "W":
                return self.either([right, self._unary("G", left)])
            return self.both([right, self._unary("F", left)])
        if left == NO:
            return {"U": right, "W": right, "R": self._unary("G", right), "M": NO}[operator]
        if left == YES:
            return {"U": self._unary("F", right), "W": YES, "R": right, "M": right}[operator]
        if operator in ("U", "R") and self.operator[right] in ("and", "or"):
            fixed = [t for t in self.operands[right] if self.suspendable(t)]
            if fixed:
                junction = self.both if self.operator[right] == "and" else self.either
                rest = junction([t for t in self.operands[right] if t not in fixed])
                return junction([self._binary(operator, left, rest), *fixed])
        if operator == "U" and self.eventual[right]:
            return right
        if operator == "R" and self.universal[right]:
            return right
        if operator == "W" and self.eventual[right]:
            return self.either([right, self._unary("G", left)])
        if operator == "M" and self.universal[right]:
            return self.both([right, self._unary("F", left)])
        return self._add(operator, (left, right))

    def goal(self, term: Term) -> Term | None:
        """The q of a term "GF q" in which all operators of q are µ; None for other terms."""
        if self.operator[term] != "G":
            return None
        inner = self.operands[term][0]
        if self.operator[inner] != "F" or self.has_greatest[inner]:
            return None
        return self.operands[inner][0]

    def formula(self, term: Term) -> Formula:
        """The formula of `term`."""
        name, operands = self.operator[term], self.operands[term]
        if name[0] in "+-":
            proposition = ast.Proposition(self.propositions[int(name[1:])])
            return proposition if name[0] == "+" else ast.Not(proposition)
        inner = [self.formula(t) for t in operands]
        if name in ("and", "or"):
            return (ast.conjunction if name == "and" else ast.disjunction)(inner)
        if name in _UNARY:
            return _UNARY[name](inner[0])
        if name in _BINARY:
            return _BINARY[name](inner[0], inner[1])
        return ast.Constant(name == "true")
