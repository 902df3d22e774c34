"""Guesses of µ- and ν-formulas, so that safety formulas and goals are left.

Esparza, Křetínský and Sickert (One Theorem to Rule Them All, LICS 2018; JACM 2020, theorem 5.2): a
word w satisfies φ just if there are a set M of µ-sub-formulas and a set N of ν-sub-formulas with

1. some suffix w_i satisfies af(φ, w_0 … w_{i-1})[M]ν, a safety formula,
2. w satisfies GF(ψ[N]µ) for every ψ in M,
3. some suffix satisfies G(ψ[M]ν) for every ψ in N.

`ψ[M]ν` takes the µ-operators of M as kept for ever (F p: true, U: W, M: R) and the others as false.

Only guesses that can matter are made: M contains a µ-formula only if it stands below a ν-operator
(any other promise is kept or broken after finitely many letters, so one can wait for it) and is
met while [M]ν is applied; N contains a ν-formula only if it is met while [N]µ is applied to M.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tiloilc.automaton.construction.guess import Guess
from tiloilc.automaton.construction.terms import GREATEST, LEAST, NO, YES, Term, Terms


class SymmetricGuess(Guess):
    """M and N."""

    def __init__(
        self, terms: Terms, chosen: Mapping[Term, bool], regenerated: frozenset[Term]
    ) -> None:
        super().__init__(terms, chosen, regenerated)
        self._weak: dict[tuple[Term, bool], Term] = {}

    def now(self, term: Term) -> Term:
        """`term`[M]ν outside every ν-operator: what only must come once is not guessed."""
        return self.weaken(term, below=False)

    def always(self) -> list[Term]:
        """ψ[M]ν for every ψ in N."""
        return [self.weaken(self.for_ever(t)) for t in self.chosen_in(GREATEST)]

    def again(self) -> list[Term]:
        """q with GF q = GF(ψ[N]µ) for every ψ in M."""
        return [self._goal(term) for term in self.chosen_in(LEAST)]

    def weaken(self, term: Term, below: bool = True) -> Term:
        """`term`[M]ν; `below`: it stands below a ν-operator."""
        terms = self.terms
        if below and not terms.has_least[term]:
            return term
        key = (term, below)
        if key not in self._weak:
            name, operands = terms.operator[term], terms.operands[term]
            lasting = None if below else self.lasting_part(term)
            if not below and terms.comes_to_stay(term):
                result = self.weaken(operands[0], below)
            elif lasting is not None:
                result = terms.make("G", self.weaken(lasting))
            elif name in LEAST and not self.chosen.get(term, below or term in self.regenerated):
                result = NO
            elif name == "F":
                result = YES
            else:
                inner = [self.weaken(t, below or name in GREATEST) for t in operands]
                result = term
                if operands:
                    result = terms.rebuild({"U": "W", "M": "R"}.get(name, name), inner)
            self._weak[key] = result
        return self._weak[key]

    def _goal(self, term: Term) -> Term:
        name, operands = self.terms.operator[term], self.terms.operands[term]
        if name in "XFU":
            return self._goal(operands[-1])
        if name == "M":
            return self.terms.both([self.strengthen(t) for t in operands])
        strong = self.strengthen(term)
        return strong if strong == term else self._goal(strong)

    def first_unknown(self, roots: Sequence[Term]) -> Term | None:
        """A sub-formula met by this guess's substitutions that is not chosen yet."""
        terms = self.terms
        seen: set[tuple[Term, str]] = set()
        work = [(t, "top") for t in reversed(roots)]
        work += [(self.for_ever(t), "below") for t in self.chosen_in(GREATEST)]
        work += [(t, "again") for t in self.chosen_in(LEAST)]
        while work:
            term, where = work.pop()
            if (term, where) in seen:
                continue
            seen.add((term, where))
            name, operands = terms.operator[term], terms.operands[term]
            if where == "again":
                where, operands = "strong", operands if name == "M" else operands[-1:]
            elif where == "strong" and name in GREATEST:
                if term not in self.chosen:
                    return term
                if self.chosen[term] or name == "G":
                    continue
            elif where == "top" and terms.comes_to_stay(term):
                pass
            elif where != "strong" and name in LEAST:
                open_ = where == "below" or term in self.regenerated
                if open_ and term not in self.chosen:
                    return term
                if name == "F" or not self.chosen.get(term, False):
                    continue
            elif where == "top" and name in GREATEST:
                where, operands = "below", self.parts_to_keep(term)
            work.extend((t, where) for t in reversed(operands) if self._matters(t, where))
        return None

    def _matters(self, term: Term, where: str) -> bool:
        """Whether the substitution changes anything in `term`."""
        strong = where == "strong"
        return self.terms.has_greatest[term] if strong else self.terms.has_least[term]
