"""What a jump guesses about the sub-formulas: which hold again and again, which hold for ever.

`ψ[N]µ` takes the ν-operators of N as true and weakens the others' promise to one that must come (G
p: false, W: U, R: M); see `symmetric.py` and `asymmetric.py` for the theorems.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from tiloilc.automaton.construction.terms import GREATEST, NO, YES, Term, Terms


class Guess(ABC):
    """A guess, perhaps still in part: `chosen[t]` says whether t is in its set.

    What is not chosen yet counts as in, which makes every result as weak as it can become.
    """

    def __init__(self, terms: Terms, chosen: Mapping[Term, bool]) -> None:
        self.terms = terms
        self.chosen = chosen
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
                result = self.rebuild({"W": "U", "R": "M"}.get(name, name), inner)
            self._strong[term] = result
        return self._strong[term]

    def rebuild(self, name: str, inner: Sequence[Term]) -> Term:
        """The operator `name` over `inner`."""
        if name in ("and", "or"):
            return self.terms.both(inner) if name == "and" else self.terms.either(inner)
        return self.terms.make(name, *inner)
