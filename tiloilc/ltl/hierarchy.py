"""The safety–progress hierarchy (Manna and Pnueli, A Hierarchy of Temporal Properties, PODC 1990).

Here as far as the syntax shows it (Chang, Manna and Pnueli, Characterization of Temporal Property
Classes, ICALP 1992; Černá and Pelánek, MFCS 2003): an upper bound. What a formula is by its
meaning, `automaton.language.classes` decides.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from tiloilc.ltl.ast import (
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
    subformulas,
)
from tiloilc.ltl.normal import nnf


class Hierarchy(StrEnum):
    """The classes, and in a few words what is asked in each."""

    BOUNDED = "bounded"
    SAFETY = "safety"
    GUARANTEE = "guarantee"
    OBLIGATION = "obligation"
    RECURRENCE = "recurrence"
    PERSISTENCE = "persistence"
    REACTIVITY = "reactivity"

    @property
    def words(self) -> str:
        """What a formula of this class asks."""
        return _WORDS[self]

    @classmethod
    def least(
        cls, *, safety: bool, guarantee: bool, recurrence: bool, persistence: bool
    ) -> Hierarchy:
        """The least class of what is in these classes."""
        if safety and guarantee:
            return cls.BOUNDED
        if safety or guarantee:
            return cls.SAFETY if safety else cls.GUARANTEE
        if recurrence and persistence:
            return cls.OBLIGATION
        if recurrence or persistence:
            return cls.RECURRENCE if recurrence else cls.PERSISTENCE
        return cls.REACTIVITY


_WORDS = {
    Hierarchy.BOUNDED: "finitely many steps decide",
    Hierarchy.SAFETY: "nothing bad ever happens",
    Hierarchy.GUARANTEE: "something good happens once (co-safety)",
    Hierarchy.OBLIGATION: "safety and guarantee combined: in the end it is decided for good",
    Hierarchy.RECURRENCE: "something good happens again and again (deterministic Büchi)",
    Hierarchy.PERSISTENCE: "from some time on something stays good (deterministic co-Büchi)",
    Hierarchy.REACTIVITY: "recurrence and persistence combined",
}


class _In(NamedTuple):
    """In which classes a formula is seen to be."""

    safety: bool
    guarantee: bool
    obligation: bool
    recurrence: bool
    persistence: bool


def syntactic_class(formula: Formula) -> Hierarchy:
    """The least class that the syntax of `formula` shows it to be in."""
    normal = nnf(formula)
    seen: dict[Formula, _In] = {}
    for part in subformulas(normal):
        seen[part] = _class(part, [seen[child] for child in part.children])
    found = seen[normal]
    return Hierarchy.least(
        safety=found.safety,
        guarantee=found.guarantee,
        recurrence=found.recurrence,
        persistence=found.persistence,
    )


def _class(part: Formula, of: list[_In]) -> _In:
    """The classes of `part`, in normal form, from those of its operands."""
    match part:
        case And() | Or() | Next():
            return _In(*(all(column) for column in zip(*of, strict=True)))
        case Eventually():
            return _made(guarantee=of[0].guarantee, persistence=of[0].persistence)
        case Always():
            return _made(safety=of[0].safety, recurrence=of[0].recurrence)
        case Until():
            left, right = of
            return _made(
                guarantee=left.guarantee and right.guarantee,
                obligation=left.obligation and right.guarantee,
                recurrence=left.recurrence and right.guarantee,
                persistence=left.persistence and right.persistence,
            )
        case WeakUntil():
            left, right = of
            return _made(
                safety=left.safety and right.safety,
                obligation=left.safety and right.obligation,
                recurrence=left.recurrence and right.recurrence,
                persistence=left.safety and right.persistence,
            )
        case Release():
            left, right = of
            return _made(
                safety=left.safety and right.safety,
                obligation=left.obligation and right.safety,
                recurrence=left.recurrence and right.recurrence,
                persistence=left.persistence and right.safety,
            )
        case StrongRelease():
            left, right = of
            return _made(
                guarantee=left.guarantee and right.guarantee,
                obligation=left.guarantee and right.obligation,
                recurrence=left.guarantee and right.recurrence,
                persistence=left.persistence and right.persistence,
            )
    return _In(True, True, True, True, True)


def _made(
    *,
    safety: bool = False,
    guarantee: bool = False,
    obligation: bool = False,
    recurrence: bool = False,
    persistence: bool = False,
) -> _In:
    """The classes, with those that contain them."""
    obligation = obligation or safety or guarantee
    return _In(safety, guarantee, obligation, recurrence or obligation, persistence or obligation)
