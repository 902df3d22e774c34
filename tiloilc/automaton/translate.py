"""LTL → LDBA: build the states, reduce, number them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Literal

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams
from tiloilc.automaton.construction.naming import name
from tiloilc.automaton.construction.symmetric import SymmetricGuess
from tiloilc.automaton.construction.terms import Terms
from tiloilc.automaton.construction.unfolding import Unfolding
from tiloilc.automaton.construction.waiting import Construction, State, Waiting
from tiloilc.automaton.draft import Draft, Row
from tiloilc.automaton.finish import edge_based, state_based
from tiloilc.automaton.ldba import Ldba
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT, Budget, too_large
from tiloilc.automaton.reduction.reduce import reduce
from tiloilc.diag import CompileError
from tiloilc.ltl.ast import Formula

Acceptance = Literal["state", "edge"]

KIND=[SymmetricGuess]
WORTH_A_GUESS = 8
"""A deterministic automaton smaller than this is not weighed against one that guesses: an agent
that need not guess learns more easily, unless it saves half of many states."""


def translate(
    formula: Formula,
    propositions: Sequence[str],
    *,
    acceptance: Acceptance = "state",
    max_states: int = MAX_STATES,
    timeout: float = TIMEOUT,
) -> Ldba:
    """An LDBA that accepts the words of `formula`; bit i of a letter is `propositions[i]`.

    Every proposition of `formula` must be among `propositions`. `acceptance="edge"` gives marked
    edges instead of accepting states, and fewer states. `timeout` is in seconds.
    Raises CompileError AUT305 when a limit is reached.
    """
    budget = Budget(max_states, timeout)
    try:
        draft, diagrams = _construct(formula, propositions, budget, eager=True)
        if not any(draft.jumps) and len(draft.rows) >= WORTH_A_GUESS:
            few = budget.share(len(draft.rows))
            try:
                guessing, others = _construct(formula, propositions, few, eager=False)
            except CompileError:
                if few.is_late:
                    raise
            else:
                if 2 * len(guessing.rows) <= len(draft.rows):
                    draft, diagrams = guessing, others
        finish = state_based if acceptance == "state" else edge_based
        return finish(draft, tuple(propositions), diagrams)
    except RecursionError:
        raise too_large("its operators are nested too deeply") from None


def _construct(
    formula: Formula, propositions: Sequence[str], budget: Budget, eager: bool
) -> tuple[Draft, Diagrams]:
    """The reduced automaton of `formula`, and the manager of its guards."""
    diagrams = Diagrams(budget)
    automaton = Construction(Unfolding(Terms(propositions, budget), diagrams), KIND[0], eager)
    return reduce(build(automaton, formula), diagrams), diagrams


def build(automaton: Construction, formula: Formula) -> Draft:
    """All states of `automaton` that can be reached from `formula`, breadth first."""
    diagrams = automaton.unfolding.diagrams
    index: dict[State, int] = {}
    states: list[State] = []
    rows: list[Row] = []
    jumps: list[tuple[int, ...]] = []

    def number(state: State) -> int:
        if state not in index:
            index[state] = len(states)
            states.append(state)
            diagrams.budget.states(len(states))
        return index[state]

    initial = automaton.initial(automaton.terms.of(formula))
    if initial is None:
        return Draft(({(0, False): TRUE},), ((),), 0, (lambda: "false",))
    number(initial)
    while len(rows) < len(states):
        state = states[len(rows)]
        row: Row = {}
        for target, mark, guard in automaton.successors(state):
            key = (number(target), mark)
            row[key] = diagrams.disj(row.get(key, FALSE), guard)
        rows.append(row)
        targets = automaton.jumps(state) if isinstance(state, Waiting) else []
        jumps.append(tuple(number(target) for target in targets))
    names = tuple(partial(name, automaton, state) for state in states)
    return Draft(tuple(rows), tuple(jumps), 0, names)
