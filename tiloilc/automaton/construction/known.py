"""Terms where something is known of the letters to come."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.automaton.construction.terms import NO, YES, Term, Terms


def given(terms: Terms, term: Term, literals: Sequence[Term]) -> Term:
    """`term` where `literals` hold now and for ever."""
    known = dict.fromkeys(literals, YES) | {terms.opposite(t): NO for t in literals}
    done: dict[Term, Term] = {}

    def rebuilt(t: Term) -> Term:
        if t in known:
            return known[t]
        if not terms.operands[t]:
            return t
        if t not in done:
            done[t] = terms.rebuild(terms.operator[t], [rebuilt(s) for s in terms.operands[t]])
        return done[t]

    return rebuilt(term) if known else term


def given_literals(terms: Terms, conjunction: Sequence[Term]) -> list[Term]:
    """The terms of a conjunction where those G p with a literal p are known."""
    known: dict[Term, None] = {}
    for term in conjunction:
        if terms.operator[term] == "G":
            inner = terms.operands[term][0]
            parts = terms.operands[inner] if terms.operator[inner] == "and" else (inner,)
            known.update((t, None) for t in parts if terms.operator[t][0] in "+-")
    if not known:
        return list(conjunction)
    found = [terms.make("G", t) for t in known]
    found += [given(terms, t, list(known)) for t in conjunction]
    return [t for t in dict.fromkeys(found) if t != YES]


def parts_of_goal(terms: Terms, goal: Term) -> list[Term]:
    """Goals that are met again and again just if `goal` is: GF(a & XF b) is GF a & GF b."""
    conjuncts = terms.operands[goal] if terms.operator[goal] == "and" else (goal,)
    later = {}
    for term in conjuncts:
        inner = term
        while terms.operator[inner] == "X":
            inner = terms.operands[inner][0]
        if terms.operator[inner] == "F":
            later[term] = terms.operands[inner][0]
    now = terms.both([t for t in conjuncts if t not in later])
    first = [] if now == YES else [now]
    return [*first, *(part for q in later.values() for part in parts_of_goal(terms, q))]
