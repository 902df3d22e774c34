"""Yes-or-no questions about formulas, for so much work and no more.

An answer that takes too long is not waited for. What counts is work, not seconds: the same question
is given up at the same point on every machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.construction.asymmetric import AsymmetricGuess
from tiloilc.automaton.construction.terms import Terms
from tiloilc.automaton.construction.unfolding import Unfolding
from tiloilc.automaton.construction.waiting import Construction
from tiloilc.automaton.draft import components
from tiloilc.automaton.limits import Budget, too_large
from tiloilc.automaton.translate import build
from tiloilc.ltl.ast import Formula, Not, conjunction

STATES = 200
"""Of one automaton, for questions that are asked of every formula."""

TICKS = 50_000
"""For all of them, a second or two: one takes a few hundred on formulas that people write."""


def small_budget() -> Budget:
    """What the questions that are asked of every formula may take together."""
    return Budget.of_work(STATES, TICKS)


def is_satisfiable(formula: Formula, propositions: Sequence[str], budget: Budget) -> bool:
    """Whether some word satisfies `formula`. Raises CompileError AUT305 when `budget` is spent."""
    unfolding = Unfolding(Terms(propositions, budget), Diagrams(budget))
    try:
        draft = build(Construction(unfolding, AsymmetricGuess), formula)
    except RecursionError:
        raise too_large("its operators are nested too deeply") from None

    def moves(state: int) -> Iterator[tuple[int, bool]]:
        for source in (state, *draft.jumps[state]):
            yield from draft.rows[source]

    graph = [list(moves(state)) for state in range(len(draft.rows))]
    component = components([[target for target, _ in edges] for edges in graph])
    return any(
        mark and component[state] == component[target]
        for state, edges in enumerate(graph)
        for target, mark in edges
    )


def implies(left: Formula, right: Formula, propositions: Sequence[str], budget: Budget) -> bool:
    """Whether every word of `left` is one of `right`. Raises CompileError AUT305."""
    return not is_satisfiable(conjunction((left, Not(right))), propositions, budget)


def equivalent(left: Formula, right: Formula, propositions: Sequence[str], budget: Budget) -> bool:
    """Whether no word tells the two apart. Raises CompileError AUT305."""
    return implies(left, right, propositions, budget) and implies(right, left, propositions, budget)
