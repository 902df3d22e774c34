"""Names of states: what is left to do, as formula text whose words are the state's language."""

from __future__ import annotations

from tiloilc.automaton.bdd import Literals, Node
from tiloilc.automaton.construction.breakpoint import Serving
from tiloilc.automaton.construction.terms import Term
from tiloilc.automaton.construction.unfolding import Unfolding
from tiloilc.automaton.construction.waiting import Construction, State
from tiloilc.ltl import to_text


def name(automaton: Construction, state: State) -> str:
    """What is left to do in `state`: what its turn waits for, what must come, what must hold."""
    terms = automaton.terms
    parts = []
    if isinstance(state, Serving):
        pending = automaton.breakpoints.pending(state)
        if pending is not None:
            parts.append(term_of(automaton.unfolding, pending))
    rest = term_of(automaton.unfolding, state.rest)
    goals = [terms.make("G", terms.make("F", goal)) for goal in state.goals]
    parts += [rest, *goals] if terms.has_least[rest] else [*goals, rest]
    return to_text(terms.formula(terms.both(parts)))


def term_of(unfolding: Unfolding, state: Node) -> Term:
    """A short term with the unfolding `state`."""
    terms, diagrams = unfolding.terms, unfolding.diagrams
    folded = unfolding.folded(state)
    node = state if folded is None else folded

    def literal(variable: int, sign: bool) -> Term:
        if variable < unfolding.letters:
            return terms.literal(variable, sign)
        term = unfolding.term(variable)
        return term if folded is not None else terms.make("X", term)

    def parts(literals: Literals, turned: bool) -> list[Term]:
        return [literal(variable, sign != turned) for variable, sign in literals]

    products = sorted(diagrams.cover(node))
    sums = sorted(diagrams.cover(diagrams.negate(node)))
    if sum(map(len, sums)) < sum(map(len, products)):
        return _all(unfolding, [_any(unfolding, parts(literals, True)) for literals in sums])
    return _any(unfolding, [_all(unfolding, parts(literals, False)) for literals in products])


def _all(unfolding: Unfolding, parts: list[Term]) -> Term:
    """The conjunction of `parts` without those that another one implies."""
    kept = sorted(set(parts))
    for part in list(kept):
        if any(other != part and unfolding.implications.implies(other, part) for other in kept):
            kept.remove(part)
    return unfolding.terms.both(kept)


def _any(unfolding: Unfolding, parts: list[Term]) -> Term:
    """The disjunction of `parts` without those that imply another one."""
    kept = sorted(set(parts))
    for part in list(kept):
        if any(other != part and unfolding.implications.implies(part, other) for other in kept):
            kept.remove(part)
    return unfolding.terms.either(kept)
