"""Formulas of linear temporal logic as immutable trees (paper, appendix C)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Constant:
    """`true` or `false`."""

    value: bool


@dataclass(frozen=True, slots=True)
class Proposition:
    """An atomic proposition."""

    name: str


@dataclass(frozen=True, slots=True)
class Not:
    """Negation."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class And:
    """Conjunction of two or more formulas, in the written order."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """Disjunction of two or more formulas, in the written order."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Implies:
    """Implication."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Iff:
    """Equivalence."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Xor:
    """Exclusive disjunction."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Next:
    """X: at the next position."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Eventually:
    """F: at some position from now on."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Always:
    """G: at every position from now on."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Until:
    """U: `right` comes, and `left` holds before."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class WeakUntil:
    """W: `left` holds until `right` comes, or for ever."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Release:
    """R: `right` holds up to and including the position where `left` comes, or for ever."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class StrongRelease:
    """M: `right` holds up to and including the position where `left` comes, and it comes."""

    left: Formula
    right: Formula


Formula = (
    Constant
    | Proposition
    | Not
    | And
    | Or
    | Implies
    | Iff
    | Xor
    | Next
    | Eventually
    | Always
    | Until
    | WeakUntil
    | Release
    | StrongRelease
)

TRUE = Constant(True)
FALSE = Constant(False)


def conjunction(operands: Iterable[Formula]) -> Formula:
    """And of any number of formulas: flat, without `true` and repetitions, in the given order."""
    return _junction(operands, And, neutral=TRUE, absorbing=FALSE)


def disjunction(operands: Iterable[Formula]) -> Formula:
    """Or of any number of formulas: flat, without `false` and repetitions, in the given order."""
    return _junction(operands, Or, neutral=FALSE, absorbing=TRUE)


def _junction(
    operands: Iterable[Formula], kind: type[And] | type[Or], neutral: Constant, absorbing: Constant
) -> Formula:
    kept: dict[Formula, None] = {}
    for operand in operands:
        for part in operand.operands if isinstance(operand, kind) else (operand,):
            if part == absorbing:
                return absorbing
            if part != neutral:
                kept.setdefault(part)
    parts = tuple(kept)
    if not parts:
        return neutral
    return parts[0] if len(parts) == 1 else kind(parts)
