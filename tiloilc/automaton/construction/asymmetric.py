"""Guesses of ν-formulas alone, so that a formula of the recurrence class is left.

Sickert, Esparza, Jaax and Křetínský (Limit-Deterministic Büchi Automata for Linear Temporal Logic,
CAV 2016), with [N]µ of the unified theory: a word w satisfies φ just if there is a set N of
ν-sub-formulas that stand below µ-operators with

1. some suffix w_i satisfies af(φ, w_0 … w_{i-1})[N], and
2. the same suffix satisfies G(ψ[N]) for every ψ in N,

where ψ[N] applies [N]µ to the µ-operators of ψ. A ν-formula holds from some place on or, if it
promises more than G, only as long as that promise is kept: so nothing else needs to be guessed.
All of it is of the recurrence class, which `breakpoint.py` makes deterministic. N contains only
formulas that are met while [N] is applied below a ν-operator; a µ-operator outside is waited for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tiloilc.automaton.construction.guess import Guess
from tiloilc.automaton.construction.terms import GREATEST, LEAST, NO, Term, Terms


class AsymmetricGuess(Guess):
    """N."""

    def __init__(
        self, terms: Terms, chosen: Mapping[Term, bool], regenerated: frozenset[Term]
    ) -> None:
        super().__init__(terms, chosen, regenerated)
        self._kept: dict[tuple[Term, bool], Term] = {}

    def now(self, term: Term) -> Term:
        """`term`[N]; a µ-formula with ν-operators in it must have come true before the jump."""
        return self._keep(term, below=False)

    def always(self) -> list[Term]:
        """ψ[N] for every ψ in N."""
        return [self._keep(self.for_ever(t), below=True) for t in self.chosen_in(GREATEST)]

    def again(self) -> list[Term]:
        """Nothing: what must come again and again is left to the breakpoints."""
        return []

    def _keep(self, term: Term, below: bool) -> Term:
        terms = self.terms
        if below and not terms.has_greatest[term]:
            return term
        key = (term, below)
        if key not in self._kept:
            name, operands = terms.operator[term], terms.operands[term]
            lasting = None if below else self.lasting_part(term)
            if name in GREATEST and term in self.chosen:
                result = self.strengthen(term)
            elif not below and terms.comes_to_stay(term):
                result = self._keep(operands[0], below)
            elif lasting is not None:
                result = terms.make("G", self._keep(lasting, below=True))
            elif name in LEAST:
                result = self.strengthen(term) if below or term in self.regenerated else NO
            else:
                inner = [self._keep(t, below or name in GREATEST) for t in operands]
                result = terms.rebuild(name, inner) if operands else term
            self._kept[key] = result
        return self._kept[key]

    def first_unknown(self, roots: Sequence[Term]) -> Term | None:
        """A ν-formula met below a µ-operator that is not chosen yet."""
        terms = self.terms
        seen: set[tuple[Term, str]] = set()
        work = [(t, "top") for t in reversed(roots)]
        work += [(self.for_ever(t), "below") for t in self.chosen_in(GREATEST)]
        while work:
            term, where = work.pop()
            if (term, where) in seen:
                continue
            seen.add((term, where))
            name, operands = terms.operator[term], terms.operands[term]
            if where == "strong" and name in GREATEST:
                if term not in self.chosen:
                    return term
                if self.chosen[term] or name == "G":
                    continue
            elif where != "strong" and terms.recurrence[term]:
                continue
            elif where == "top" and terms.comes_to_stay(term):
                pass
            elif where == "top" and name in LEAST and term not in self.regenerated:
                continue
            elif name in LEAST:
                where = "strong"
            elif where == "top" and name in GREATEST:
                where, operands = "below", self.parts_to_keep(term)
            work.extend((t, where) for t in reversed(operands) if terms.has_greatest[t])
        return None
