"""Ultimately periodic words and what LTL means on them: the oracle of every translation.

The truth of a sub-formula is kept as one integer: bit i tells whether it holds at position i of
stem and loop. X is a shift, the other temporal operators are fixpoints of their expansion laws
(Baier and Katoen, Principles of Model Checking, section 5.1.4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
)

Letter = int
"""A letter of 2^AP as bits: bit i is the i-th proposition."""


@dataclass(frozen=True, slots=True)
class Lasso:
    """The infinite word `stem` · `loop`^ω."""

    stem: tuple[Letter, ...]
    loop: tuple[Letter, ...]

    def __post_init__(self) -> None:
        assert self.loop, "a lasso goes round"

    @property
    def letters(self) -> tuple[Letter, ...]:
        """The letters of all positions: stem, then one round of the loop."""
        return self.stem + self.loop

    def suffix(self, start: int) -> Lasso:
        """The word without its first `start` letters."""
        if start <= len(self.stem):
            return Lasso(self.stem[start:], self.loop)
        turn = (start - len(self.stem)) % len(self.loop)
        return Lasso((), self.loop[turn:] + self.loop[:turn])


def holds(formula: Formula, lasso: Lasso, propositions: Sequence[str]) -> bool:
    """Whether `lasso` satisfies `formula`; bit i of a letter is `propositions[i]`."""
    letters = lasso.letters
    everywhere = (1 << len(letters)) - 1
    last, back = len(letters) - 1, len(lasso.stem)
    places = {
        name: sum(1 << i for i, letter in enumerate(letters) if letter >> bit & 1)
        for bit, name in enumerate(propositions)
    }

    def shifted(value: int) -> int:
        return value >> 1 | (value >> back & 1) << last

    def fixpoint(start: int, now: int, keep: int) -> int:
        """The fixpoint of v = now | (keep & X v): least from 0, greatest from everywhere."""
        value = start
        while (following := now | (keep & shifted(value))) != value:
            value = following
        return value

    @cache
    def where(f: Formula) -> int:
        match f:
            case Proposition(name):
                return places[name]
            case Constant(value):
                return everywhere if value else 0
            case Not(operand):
                return everywhere ^ where(operand)
            case And(operands):
                value = everywhere
                for operand in operands:
                    value &= where(operand)
                return value
            case Or(operands):
                value = 0
                for operand in operands:
                    value |= where(operand)
                return value
            case Implies(left, right):
                return (everywhere ^ where(left)) | where(right)
            case Iff(left, right):
                return everywhere ^ where(left) ^ where(right)
            case Xor(left, right):
                return where(left) ^ where(right)
            case Next(operand):
                return shifted(where(operand))
            case Eventually(operand):
                return fixpoint(0, where(operand), everywhere)
            case Always(operand):
                return fixpoint(everywhere, 0, where(operand))
            case Until(left, right):
                return fixpoint(0, where(right), where(left))
            case WeakUntil(left, right):
                return fixpoint(everywhere, where(right), where(left))
            case Release(left, right):
                both = where(left) & where(right)
                return fixpoint(everywhere, both, where(right))
            case StrongRelease(left, right):
                both = where(left) & where(right)
                return fixpoint(0, both, where(right))

    return bool(where(formula) & 1)
