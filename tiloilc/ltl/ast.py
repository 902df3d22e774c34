"""Formulas of linear temporal logic as immutable trees (paper, appendix C)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


class _Node:
    """A formula compares by structure; its hash is computed once, so that caches stay cheap."""

    __slots__ = ("_hash",)
    __match_args__: tuple[str, ...] = ()

    _hash: int

    def __hash__(self) -> int:
        try:
            return self._hash
        except AttributeError:
            value = hash((type(self).__name__, self._parts()))
            object.__setattr__(self, "_hash", value)
            return value

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other) or hash(self) != hash(other):
            return False
        assert isinstance(other, _Node)
        return _equal(self, other)

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), tuple(getattr(self, name) for name in self.__match_args__)

    @property
    def children(self) -> tuple[Formula, ...]:
        """The operands, in the written order."""
        return ()

    def _parts(self) -> object:
        raise NotImplementedError


def _equal(one: _Node, other: _Node) -> bool:
    """Structural equality of formulas of one kind, without recursion.

    Each pair of parts is looked at once, so that formulas with many shared parts stay cheap.
    """
    seen: set[tuple[int, int]] = set()
    waiting = [(one, other)]
    while waiting:
        left, right = waiting.pop()
        operands, others = left.children, right.children
        if len(operands) != len(others) or (not operands and left._parts() != right._parts()):
            return False
        for pair in zip(operands, others, strict=True):
            left, right = pair
            if left is right:
                continue
            if type(left) is not type(right) or hash(left) != hash(right):
                return False
            known = (id(left), id(right))
            if known not in seen:
                seen.add(known)
                waiting.append(pair)
    return True


@dataclass(frozen=True, slots=True, eq=False)
class Constant(_Node):
    """`true` or `false`."""

    value: bool

    def _parts(self) -> object:
        return self.value


@dataclass(frozen=True, slots=True, eq=False)
class Proposition(_Node):
    """An atomic proposition."""

    name: str

    def _parts(self) -> object:
        return self.name


@dataclass(frozen=True, slots=True, eq=False)
class Unary(_Node):
    """An operator with one operand."""

    operand: Formula

    @property
    def children(self) -> tuple[Formula, ...]:
        """The operand."""
        return (self.operand,)

    def _parts(self) -> object:
        return self.operand


@dataclass(frozen=True, slots=True, eq=False)
class Binary(_Node):
    """An operator with two operands."""

    left: Formula
    right: Formula

    @property
    def children(self) -> tuple[Formula, ...]:
        """The operands, left first."""
        return (self.left, self.right)

    def _parts(self) -> object:
        return (self.left, self.right)


@dataclass(frozen=True, slots=True, eq=False)
class Junction(_Node):
    """An associative operator with two or more operands, in the written order."""

    operands: tuple[Formula, ...]

    @property
    def children(self) -> tuple[Formula, ...]:
        """The operands, in the written order."""
        return self.operands

    def _parts(self) -> object:
        return self.operands


@dataclass(frozen=True, slots=True, eq=False)
class Not(Unary):
    """Negation."""


@dataclass(frozen=True, slots=True, eq=False)
class And(Junction):
    """Conjunction."""


@dataclass(frozen=True, slots=True, eq=False)
class Or(Junction):
    """Disjunction."""


@dataclass(frozen=True, slots=True, eq=False)
class Implies(Binary):
    """Implication."""


@dataclass(frozen=True, slots=True, eq=False)
class Iff(Binary):
    """Equivalence."""


@dataclass(frozen=True, slots=True, eq=False)
class Xor(Binary):
    """Exclusive disjunction."""


@dataclass(frozen=True, slots=True, eq=False)
class Next(Unary):
    """X: at the next position."""


@dataclass(frozen=True, slots=True, eq=False)
class Eventually(Unary):
    """F: at some position from now on."""


@dataclass(frozen=True, slots=True, eq=False)
class Always(Unary):
    """G: at every position from now on."""


@dataclass(frozen=True, slots=True, eq=False)
class Until(Binary):
    """U: `right` comes, and `left` holds before."""


@dataclass(frozen=True, slots=True, eq=False)
class WeakUntil(Binary):
    """W: `left` holds until `right` comes, or for ever."""


@dataclass(frozen=True, slots=True, eq=False)
class Release(Binary):
    """R: `right` holds up to and including the position where `left` comes, or for ever."""


@dataclass(frozen=True, slots=True, eq=False)
class StrongRelease(Binary):
    """M: `right` holds up to and including the position where `left` comes, and it comes."""


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
            if isinstance(part, Constant):
                if part.value == absorbing.value:
                    return absorbing
            else:
                kept.setdefault(part)
    parts = tuple(kept)
    if not parts:
        return neutral
    return parts[0] if len(parts) == 1 else kind(parts)


def subformulas(formula: Formula) -> tuple[Formula, ...]:
    """Every distinct sub-formula once, operands before operators, `formula` last.

    A pass that goes through them in this order finds the results of the operands ready: it needs
    no recursion, so a deep formula cannot overflow the stack.
    """
    done: dict[Formula, None] = {}
    waiting: list[tuple[Formula, bool]] = [(formula, False)]
    while waiting:
        part, entered = waiting.pop()
        children = part.children
        if entered or not children:
            done.setdefault(part)
        elif part not in done:
            waiting.append((part, True))
            waiting.extend([(child, False) for child in reversed(children)])
    return tuple(done)


def propositions_of(formula: Formula) -> tuple[str, ...]:
    """The names of the propositions, in the order of their first appearance."""
    return tuple(part.name for part in subformulas(formula) if isinstance(part, Proposition))
