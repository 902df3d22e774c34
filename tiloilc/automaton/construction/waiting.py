"""The states that wait and the jumps they may take, for all of LTL.

A waiting state tracks what is left of the formula. A jump guesses what holds in the long run and
goes to a deterministic state for the rest, see `breakpoint.py`. Waiting ends without a jump as soon
as what is left is of the recurrence class.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import NamedTuple

from tiloilc.automaton.bdd import FALSE, TRUE, Node
from tiloilc.automaton.construction.breakpoint import Breakpoints, Goals, Serving
from tiloilc.automaton.construction.guess import Guess, regenerated_by
from tiloilc.automaton.construction.known import given_literals
from tiloilc.automaton.construction.terms import NO, YES, Term
from tiloilc.automaton.construction.unfolding import Unfolding


class Waiting(NamedTuple):
    """A state that tracks what is left: the word must satisfy `rest` and GF of each goal."""

    rest: Node
    goals: Goals


State = Waiting | Serving


class Construction:
    """All states of the automaton of one formula, with the guesses of `kind`.

    `patient`: jumps are taken also where all that is left is of the recurrence class, and could
    be had without. `free`: the goals of a chain need not come in the written order.
    """

    def __init__(
        self, unfolding: Unfolding, kind: type[Guess], patient: bool = False, free: bool = False
    ) -> None:
        self.unfolding = unfolding
        self.terms = unfolding.terms
        self.breakpoints = Breakpoints(unfolding, free)
        self._kind = kind
        self._ends_waiting = self._simple if patient else self._in_class

    def initial(self, formula: Term) -> State | None:
        """The first state; None if the formula is false by propositional reasoning."""
        goals = map(self.terms.goal, self.terms)
        self.breakpoints.written = frozenset(q for q in goals if q is not None)
        return self._enter(self.unfolding.later(formula), ())

    def offers_a_choice(self, formula: Term) -> bool:
        """Whether `formula` has alternatives that are settled in the long run, as GF a | GF b."""
        left, _ = self.breakpoints.settle(self.unfolding.later(formula), ())
        term = self.unfolding.term
        cubes = self.unfolding.diagrams.cover(left)
        return len(cubes) > 1 and all(
            any(self.terms.suspendable(term(v)) for v, _ in cube) for cube in cubes
        )

    def _enter(self, rest: Node, goals: Goals) -> State | None:
        left, goals = self.breakpoints.settle(rest, goals)
        unfolded = self.unfolding.step(left)
        if unfolded == FALSE:
            return None
        if self._ends_waiting(unfolded):
            return self.breakpoints.start(left, goals)
        return Waiting(self.unfolding.step_suspended(left), goals)

    def _in_class(self, state: Node) -> bool:
        """Whether `state` is of the recurrence class."""
        return all(self.terms.recurrence[t] for t in self.unfolding.left_over(state))

    def _simple(self, state: Node) -> bool:
        """Whether `state` is made of co-safety and safety formulas."""
        terms = self.terms
        return not any(
            terms.has_least[t] and terms.has_greatest[t] for t in self.unfolding.left_over(state)
        )

    def step(self, state: State) -> Hashable:
        """The step of a written chain that `state` stands for, if any."""
        return self.breakpoints.step(state) if isinstance(state, Serving) else None

    def successors(self, state: State) -> list[tuple[State, bool, Node]]:
        """The edges of `state`: target, whether it accepts, letters."""
        if isinstance(state, Serving):
            return list(self.breakpoints.successors(state))
        edges = []
        for (rest,), guard in self.breakpoints.split(state.rest).items():
            target = self._enter(rest, state.goals)
            if target is not None:
                edges.append((target, False, guard))
        return edges

    def jumps(self, state: Waiting) -> list[Serving]:
        """The deterministic states that `state` may become."""
        targets: dict[Serving, None] = {}
        for guess in self._guesses(state.rest):
            targets.update(dict.fromkeys(self._checking(state, guess)))
        return list(targets)

    def _checking(self, state: Waiting, guess: Guess) -> list[Serving]:
        """The states that check `guess` from now on, of which one must be chosen."""
        goals = guess.again()
        rest = self._remainder(state.rest, guess)
        if rest == FALSE or NO in goals:
            return []
        wanted = [goal for goal in goals if goal != YES]
        together = tuple(dict.fromkeys([*state.goals, *wanted]))
        unfolded = not self._is_suspended(state.rest)
        lasting, mixed = self._alternatives(rest, guess.regenerated, unfolded)
        targets = [
            self.breakpoints.start(*self.breakpoints.settle(left, together)) for left in lasting
        ]
        if mixed != FALSE:
            mixed = mixed if unfolded else self.unfolding.step(mixed)
            targets.append(self.breakpoints.resume(mixed, together))
        return targets

    def _remainder(self, rest: Node, guess: Guess) -> Node:
        """What must hold from now on if `guess` is right; what was suspended is so no more."""
        unfolding, terms = self.unfolding, self.terms
        at_once = unfolding.later if self._is_suspended(rest) else unfolding.unfold

        def value(term: Term) -> Node:
            now = guess.now(term)
            return at_once(now) if terms.suspendable(term) else unfolding.later(now)

        left = unfolding.put(rest, value)
        for term in guess.always():
            left = unfolding.diagrams.conj(left, at_once(terms.make("G", term)))
        return left

    def _is_suspended(self, rest: Node) -> bool:
        """Whether no letter matters to `rest`, only the long run: it need not be unfolded."""
        unfolding = self.unfolding
        return min(unfolding.diagrams.support(rest)) >= unfolding.letters and all(
            self.terms.suspendable(term) for term in unfolding.left_over(rest)
        )

    def _alternatives(
        self, rest: Node, regenerated: frozenset[Term], unfolded: bool
    ) -> tuple[list[Node], Node]:
        """`rest` as alternatives that a jump may choose from: one of `G a | G b` each.

        An alternative stands alone, as what is left from now on, where formulas that, once true,
        stay true say it whole: which of them become true is settled in the long run, so that nobody
        has to guess what chance decides later. One that will be said so after the next letters is
        left to later jumps. All others are one, unfolded.
        """
        unfolding, diagrams = self.unfolding, self.unfolding.diagrams
        lower = [v for v in sorted(diagrams.support(rest)) if v >= unfolding.letters]
        cubes = {
            tuple(v for v, _ in cube if v >= unfolding.letters) for cube in diagrams.cover(rest)
        }
        parts: dict[Node, None] = {}
        mixed = FALSE
        for cube in sorted(cubes, key=lambda cube: sorted(map(unfolding.term, cube))):
            said = [unfolding.term(v) for v in cube]
            terms = given_literals(self.terms, said)
            if NO in terms:
                continue
            lasting = self._later([t for t in said if self.terms.universal[t]])
            left = self._later([t for t in terms if self.terms.universal[t]])
            if unfolded:
                lasting = unfolding.step(lasting)
            passing = [t for t in terms if not self.terms.universal[t]]
            letters = diagrams.assign(rest, {v: v in cube for v in lower})
            if diagrams.implies(lasting, rest) or (
                not passing and diagrams.implies(unfolding.step(left), letters)
            ):
                parts[left] = None
            elif self._comes_back(letters, regenerated) or any(
                t in regenerated or not self._is_bounded(t) for t in passing
            ):
                mixed = diagrams.disj(mixed, diagrams.conj(letters, self._later(terms)))
        return [*parts], mixed

    def _later(self, terms: Sequence[Term]) -> Node:
        """X of the conjunction of `terms`."""
        result = TRUE
        for term in terms:
            result = self.unfolding.diagrams.conj(result, self.unfolding.later(term))
        return result

    def _comes_back(self, letters: Node, regenerated: frozenset[Term]) -> bool:
        """Whether a literal that `letters` ask for is regenerated, so that later ones ask too."""
        asked = {str(v) for v in self.unfolding.diagrams.support(letters)}
        names = (self.terms.operator[t] for t in regenerated)
        return any(name[1:] in asked for name in names if name[0] in "+-")

    def _is_bounded(self, term: Term) -> bool:
        """Whether a bounded number of letters settles `term`."""
        return not (self.terms.has_least[term] or self.terms.has_greatest[term])

    def _guesses(self, rest: Node) -> Iterator[Guess]:
        """All complete guesses for `rest`, each made only as far as it matters."""
        roots = self.unfolding.left_over(rest)
        regenerated = regenerated_by(self.terms, roots)
        open_guesses: list[dict[Term, bool]] = [{}]
        while open_guesses:
            self.unfolding.diagrams.budget.tick()
            guess = self._kind(self.terms, open_guesses.pop(), regenerated)
            unknown = guess.first_unknown(roots)
            if unknown is None:
                yield guess
            elif self._remainder(rest, guess) != FALSE:
                open_guesses.append({**guess.chosen, unknown: True})
                open_guesses.append({**guess.chosen, unknown: False})
