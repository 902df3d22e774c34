"""LTL → LDBA: build the states, reduce, number them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
from tiloilc.automaton.draft import Draft, Row, reachable
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

WORTH_A_GUESS = 8
"""A deterministic automaton smaller than this is not weighed against one that guesses: an agent
that need not guess learns more easily, unless that costs a third more of many states."""

WORTH_THE_WORK = 3
"""Times the work of the first construction that another one may take, and …"""

WORK_ALLOWED = 5_000
"""… ticks besides, about 20 ms."""

WORTH_A_SECOND = 8
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
    attempt = _Attempt(formula, propositions, free=order == "free")
    try:
        if construction == "auto":
            draft, diagrams = attempt.smallest(budget)
        else:
            draft, diagrams = attempt.with_guesses(GUESSES[construction], budget)
        finish = state_based if acceptance == "state" else edge_based
        return finish(draft, tuple(propositions), diagrams)
    except RecursionError:
        raise too_large("its operators are nested too deeply") from None


@dataclass(frozen=True, slots=True)
class _Attempt:
    """A formula to translate in one way or another; each way gives a draft and its diagrams."""

    formula: Formula
    propositions: Sequence[str]
    free: bool

    def smallest(self, budget: Budget) -> tuple[Draft, Diagrams]:
        """The asymmetric automaton, or another one if that is much better and no more work."""
        found = self.with_guesses(AsymmetricGuess, budget)
        count, guesses = len(found[0].rows), any(found[0].jumps)
        if guesses and count >= WORTH_A_SECOND and _beyond_jumps(found[0]) > 1:
            return self._other(SymmetricGuess, False, budget, count - 1) or found
        if not guesses and count >= WORTH_A_GUESS and self._offers_a_choice(budget):
            return self._other(AsymmetricGuess, True, budget, 3 * count // 4) or found
        return found

    def _other(
        self, kind: type[Guess], patient: bool, budget: Budget, most: int
    ) -> tuple[Draft, Diagrams] | None:
        """What another way gives for as much work again; None if more than `most` states."""
        part = budget.share(WORTH_THE_WORK * budget.ticks + WORK_ALLOWED)
        try:
            found = self.with_guesses(kind, part, patient)
        except CompileError:
            if part.is_late:
                raise
            return None
        part.release()
        return found if len(found[0].rows) <= most else None

    def _offers_a_choice(self, budget: Budget) -> bool:
        construction = self._construction(AsymmetricGuess, budget, patient=True)
        return construction.offers_a_choice(construction.terms.of(self.formula))

    def with_guesses(
        self, kind: type[Guess], budget: Budget, patient: bool = False
    ) -> tuple[Draft, Diagrams]:
        """The reduced automaton of one construction."""
        construction = self._construction(kind, budget, patient)
        diagrams = construction.unfolding.diagrams
        return reduce(build(construction, self.formula), diagrams), diagrams

    def _construction(
        self, kind: type[Guess], budget: Budget, patient: bool = False
    ) -> Construction:
        unfolding = Unfolding(Terms(self.propositions, budget, patient), Diagrams(budget))
        return Construction(unfolding, kind, patient, self.free)


def _beyond_jumps(draft: Draft) -> int:
    """How many states are reached by jumps only: all that another kind of guesses can change."""
    graph = [list(dict.fromkeys(t for t, _ in row)) for row in draft.rows]
    return len(draft.rows) - len(reachable(graph, [draft.initial]))


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
