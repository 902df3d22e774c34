"""Implications between terms, found by their syntax alone (after Somenzi and Bloem, CAV 2000)."""

from __future__ import annotations

from tiloilc.automaton.construction.terms import NO, YES, Term, Terms


class Implications:
    """What is known to imply what among the terms of one table."""

    def __init__(self, terms: Terms) -> None:
        self.terms = terms
        self._known: dict[tuple[Term, Term], bool] = {}

    def implies(self, left: Term, right: Term) -> bool:
        """Whether `left` ⟹ `right` by syntax; False says nothing."""
        if left in (NO, right) or right == YES:
            return True
        key = (left, right)
        if key not in self._known:
            self._known[key] = False
            self._known[key] = self._implication(left, right)
        return self._known[key]

    def _implication(self, p: Term, q: Term) -> bool:
        of, said = self.implies, self.terms.operator
        p_name, q_name = said[p], said[q]
        p_in, q_in = self.terms.operands[p], self.terms.operands[q]
        if p_name == "or":
            return all(of(t, q) for t in p_in)
        if q_name == "and":
            return all(of(p, t) for t in q_in)
        if p_name == "and" and any(of(t, q) for t in p_in):
            return True
        if q_name == "or" and any(of(p, t) for t in q_in):
            return True
        if q_name in "FUW" and of(p, q_in[-1]):
            return True
        if q_name in "RM" and of(p, q_in[0]) and of(p, q_in[1]):
            return True
        if p_name in "GRM" and of(p_in[-1], q):
            return True
        if p_name in "UW" and of(p_in[0], q) and of(p_in[1], q):
            return True
        if p_name in "XFU" and self.terms.eventual[q] and of(p_in[-1], q):
            return True
        if p_name == "M" and self.terms.eventual[q] and of(p_in[0], q):
            return True
        if q_name in "XGR" and self.terms.universal[p] and of(p, q_in[-1]):
            return True
        if q_name == "W" and self.terms.universal[p] and of(p, q_in[0]):
            return True
        weaker = {"X": "X", "F": "F", "G": "GR", "U": "UWF", "W": "W", "R": "R", "M": "MR"}
        if q_name in weaker.get(p_name, "") and len(p_in) == len(q_in):
            return all(of(s, t) for s, t in zip(p_in, q_in, strict=True))
        return False
