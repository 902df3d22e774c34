"""What a jump guesses about the sub-formulas: which hold again and again, which hold for ever.

`ψ[N]µ` takes the ν-operators of N as true and weakens the others' promise to one that must come (G
p: false, W: U, R: M); see `symmetric.py` and `asymmetric.py` for the theorems.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from tiloilc.automaton.construction.known import given
from tiloilc.automaton.construction.terms import GREATEST, NO, YES, Term, Terms


class Guess(ABC):
    """A guess, perhaps still in part: `chosen[t]` says whether t is in its set.

    What is not chosen yet counts as in, which makes every result as weak as it can become.
    `regenerated` are the sub-formulas of what is left over that stand below a ν-operator, and so
    may be left over again and again. Any other promise is kept or broken after finitely many
    letters, so that a jump can wait for it: of the others, left over at a jump, a µ-formula counts
    as false, p W q and q R p as G p.
    """

    def __init__(
        self, terms: Terms, chosen: Mapping[Term, bool], regenerated: frozenset[Term]
    ) -> None:
        self.terms = terms
        self.chosen = chosen
        self.regenerated = regenerated
        self._strong: dict[Term, Term] = {}

    @abstractmethod
    def now(self, term: Term) -> Term:
        """What takes the place of `term`, which is left over when the jump is taken."""

    @abstractmethod
    def always(self) -> list[Term]:
        """What must hold from now on at every place, in the written order."""

    @abstractmethod
    def again(self) -> list[Term]:
        """Each q of the GF q that must hold, in the written order."""

    @abstractmethod
    def first_unknown(self, roots: Sequence[Term]) -> Term | None:
        """A sub-formula met on the way from `roots` and the guess that is not chosen yet."""

    def lasting_part(self, term: Term) -> Term | None:
        """The p if `term`, left over once, can only be kept for ever as G p; else None."""
        name = self.terms.operator[term]
        if name != "G" and (name not in GREATEST or term in self.regenerated):
            return None
        return self.for_ever(term)

    def parts_to_keep(self, term: Term) -> tuple[Term, ...]:
        """What the substitutions go on with in a ν-formula that is left over."""
        lasting = self.lasting_part(term)
        return self.terms.operands[term] if lasting is None else (lasting,)

    def for_ever(self, term: Term) -> Term:
        """The p such that the ν-formula `term` may never be broken, nor ended, if G p.

        q W r and r R q are so kept by G (q & !r); where r comes again and again they are q U r
        and r M q.
        """
        terms = self.terms
        name, operands = terms.operator[term], terms.operands[term]
        if name == "G":
            return operands[0]
        kept, end = operands if name == "W" else reversed(operands)
        parts = terms.operands[end] if terms.operator[end] == "or" else (end,)
        never = [terms.opposite(t) for t in parts if terms.operator[t][0] in "+-"]
        return terms.both([*never, given(terms, kept, never)])

    def chosen_in(self, operators: frozenset[str]) -> list[Term]:
        """The chosen terms with one of `operators`."""
        chosen = sorted(self.chosen.items())
        return [t for t, is_in in chosen if is_in and self.terms.operator[t] in operators]

    def strengthen(self, term: Term) -> Term:
        """`term`[N]µ."""
        terms = self.terms
        if not terms.has_greatest[term]:
            return term
        if term not in self._strong:
            name, operands = terms.operator[term], terms.operands[term]
            if name in GREATEST and self.chosen.get(term, True):
                result = YES
            elif name == "G":
                result = NO
            else:
                inner = [self.strengthen(t) for t in operands]
                result = self.terms.rebuild({"W": "U", "R": "M"}.get(name, name), inner)
            self._strong[term] = result
        return self._strong[term]


def regenerated_by(terms: Terms, roots: Sequence[Term]) -> frozenset[Term]:
    """The sub-formulas of `roots` below a ν-operator, where a jump cannot wait for anything."""
    below: set[Term] = set()
    seen: set[tuple[Term, bool]] = set()
    work = [(t, False) for t in roots]
    while work:
        term, is_below = work.pop()
        if (term, is_below) in seen:
            continue
        seen.add((term, is_below))
        name = terms.operator[term]
        if is_below:
            below.add(term)
        work.extend((t, is_below or name in GREATEST) for t in terms.operands[term])
    return frozenset(below)
