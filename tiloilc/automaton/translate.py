"""LTL → LDBA: build the states, reduce, number them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Literal

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams
from tiloilc.automaton.construction.asymmetric import AsymmetricGuess
from tiloilc.automaton.construction.guess import Guess
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
ConstructionName = Literal["auto", "asymmetric", "symmetric"]
Order = Literal["written", "free"]

GUESSES: dict[str, type[Guess]] = {"asymmetric": AsymmetricGuess, "symmetric": SymmetricGuess}

WORTH_A_SECOND = 12
"""States with jumps from which on the other construction is tried too: below, it never won."""


def translate(
    formula: Formula,
    propositions: Sequence[str],
    *,
    acceptance: Acceptance = "state",
    construction: ConstructionName = "auto",
    order: Order = "written",
    max_states: int = MAX_STATES,
    timeout: float = TIMEOUT,
) -> Ldba:
    """An LDBA that accepts the words of `formula`; bit i of a letter is `propositions[i]`.

    Every proposition of `formula` must be among `propositions`. `acceptance="edge"` gives marked
    edges instead of accepting states, and fewer states. `construction` says what jumps guess
    (`asymmetric.py`, `symmetric.py`); "auto" keeps the smaller automaton. `order="written"` keeps
    the steps of a chain `G F (a & X F b)` as they are written; "free" need not, and may be smaller.
    `timeout` is in seconds. Raises CompileError AUT305 when a limit is reached.
    """
    budget = Budget(max_states, timeout)
    free = order == "free"
    try:
        if construction == "auto":
            draft, diagrams = _smaller(formula, propositions, budget, free)
        else:
            guess = GUESSES[construction]
            draft, diagrams = _construct(formula, propositions, budget, guess, free)
        finish = state_based if acceptance == "state" else edge_based
        return finish(draft, tuple(propositions), diagrams)
    except RecursionError:
        raise too_large("its operators are nested too deeply") from None


def _smaller(
    formula: Formula, propositions: Sequence[str], budget: Budget, free: bool
) -> tuple[Draft, Diagrams]:
    """The asymmetric automaton, or the symmetric one if that is smaller and no more work."""
    found = _construct(formula, propositions, budget, AsymmetricGuess, free)
    if not any(found[0].jumps) or len(found[0].rows) < WORTH_A_SECOND:
        return found
    rest = budget.share(budget.max_states, budget.ticks)
    try:
        other = _construct(formula, propositions, rest, SymmetricGuess, free)
    except CompileError:
        if rest.is_late:
            raise
        return found
    rest.release()
    return other if len(other[0].rows) < len(found[0].rows) else found


def _construct(
    formula: Formula, propositions: Sequence[str], budget: Budget, guess: type[Guess], free: bool
) -> tuple[Draft, Diagrams]:
    """The reduced automaton of `formula`, and the manager of its guards."""
    diagrams = Diagrams(budget)
    unfolding = Unfolding(Terms(propositions, budget), diagrams)
    return reduce(build(Construction(unfolding, guess, free), formula), diagrams), diagrams


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
    steps = tuple(map(automaton.step, states))
    return Draft(tuple(rows), tuple(jumps), 0, names, steps if any(steps) else ())
