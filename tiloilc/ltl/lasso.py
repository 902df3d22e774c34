"""Ultimately periodic words and what LTL means on them: the oracle of every translation.

The truth of a sub-formula is kept as one integer: bit i tells whether it holds at position i of
stem and loop. X is a shift, the other temporal operators are fixpoints of their expansion laws
(Baier and Katoen, Principles of Model Checking, section 5.1.4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
    subformulas,
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
    """Whether `lasso` satisfies `formula`; bit i of a letter is `propositions[i]`.

    Every proposition of the formula must be among `propositions`.
    """
    positions = _Positions(lasso)
    truth: dict[Formula, int] = {}
    for part in subformulas(formula):
        if isinstance(part, Proposition):
            assert part.name in propositions, f"`{part.name}` is not in the word's alphabet"
            truth[part] = positions.where(propositions.index(part.name))
        else:
            truth[part] = _truth(part, [truth[child] for child in part.children], positions)
    return bool(truth[formula] & 1)


class _Positions:
    """Sets of positions of one lasso, as bits."""

    def __init__(self, lasso: Lasso) -> None:
        self.letters = lasso.letters
        self.everywhere = (1 << len(self.letters)) - 1
        self.last = len(self.letters) - 1
        self.back = len(lasso.stem)

    def where(self, bit: int) -> int:
        """The positions whose letter has `bit`."""
        return sum(1 << i for i, letter in enumerate(self.letters) if letter >> bit & 1)

    def before(self, value: int) -> int:
        """The positions whose successor is in `value`: the last one is followed by the loop."""
        return value >> 1 | (value >> self.back & 1) << self.last

    def fixpoint(self, start: int, now: int, keep: int) -> int:
        """The fixpoint of v = now | (keep & X v): least from nowhere, greatest from everywhere."""
        value = start
        while (following := now | (keep & self.before(value))) != value:
            value = following
        return value


def _truth(part: Formula, truth: list[int], positions: _Positions) -> int:
    """Where `part` holds, if its operands hold at the positions `truth`."""
    everywhere, fixpoint = positions.everywhere, positions.fixpoint
    match part:
        case Constant(value):
            return everywhere if value else 0
        case Not():
            return everywhere ^ truth[0]
        case And():
            common = everywhere
            for operand in truth:
                common &= operand
            return common
        case Or():
            union = 0
            for operand in truth:
                union |= operand
            return union
        case Implies():
            return everywhere ^ truth[0] | truth[1]
        case Iff():
            return everywhere ^ truth[0] ^ truth[1]
        case Xor():
            return truth[0] ^ truth[1]
        case Next():
            return positions.before(truth[0])
        case Eventually():
            return fixpoint(0, truth[0], everywhere)
        case Always():
            return fixpoint(everywhere, 0, truth[0])
        case Until():
            return fixpoint(0, truth[1], truth[0])
        case WeakUntil():
            return fixpoint(everywhere, truth[1], truth[0])
        case Release():
            return fixpoint(everywhere, truth[0] & truth[1], truth[1])
        case StrongRelease():
            return fixpoint(0, truth[0] & truth[1], truth[1])
    raise AssertionError(f"not an operator: {part!r}")
