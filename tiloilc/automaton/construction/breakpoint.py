"""Deterministic Büchi automata for the recurrence class, by breakpoints and goals in turn.

A state is (ξ, goals, turn, ζ): the word must satisfy ξ, a formula in which no ν-operator stands
below a µ-operator, and GF q for each goal q, all of whose operators are µ. ζ is what the source
whose turn it is still has to bring: turn 0 is ξ itself, whose promises made so far are
ξ[all ν true]µ (Sickert and Esparza, An Efficient Normalisation Procedure for LTL, LICS 2020,
section 6: ξ holds just if these promises are kept again and again); turn k is the k-th goal, as
F q. When ζ has come true the turn passes on; a round completed is an accepting edge. Goals that
the same letter fulfils at once are passed over; a goal in progress starts with the next letter,
so GF(a & XF b) waits for a, then for b.
"""

from __future__ import annotations

from typing import NamedTuple

from tiloilc.automaton.bdd import FALSE, TRUE, Node, Split
from tiloilc.automaton.construction.known import parts_of_goal
from tiloilc.automaton.construction.terms import GREATEST, YES, Term
from tiloilc.automaton.construction.unfolding import Unfolding

Goals = tuple[Term, ...]
"""Terms q of "GF q", each once, in the written order."""


class Serving(NamedTuple):
    """A state of the deterministic part."""

    rest: Node
    goals: Goals
    turn: int
    promise: Node


class Breakpoints:
    """The deterministic part: where the states of the recurrence class lead."""

    def __init__(self, unfolding: Unfolding, free: bool = False) -> None:
        self.unfolding = unfolding
        self.written: frozenset[Term] = frozenset()
        self._free = free
        self.terms = unfolding.terms
        self._splits: dict[tuple[Node, ...], Split] = {}
        self._sources: dict[Node, list[tuple[int, Node]]] = {}
        self._parts: dict[Term, frozenset[Term]] = {}
        self._promised: dict[Term, Term] = {}
        self._met: dict[Term, Node] = {}
        self._tidied: dict[Node, Node] = {}

    def split(self, *functions: Node) -> Split:
        """What diagrams leave for later, with the letters that lead there."""
        return self.unfolding.diagrams.split(functions, self.unfolding.letters, self._splits)

    def settle(self, rest: Node, goals: Goals) -> tuple[Node, Goals]:
        """Tidy `rest`, a diagram over "X t": conjuncts GF q become goals, implied terms go."""
        terms, unfolding, diagrams = self.terms, self.unfolding, self.unfolding.diagrams
        found = list(goals)
        rest = self._tidy(rest)
        for variable in sorted(diagrams.support(rest)):
            goal = terms.goal(unfolding.term(variable))
            if goal is None or diagrams.assign(rest, {variable: False}) != FALSE:
                continue
            found.extend(parts_of_goal(terms, goal) if self._free else [goal])
            waiting = diagrams.support(unfolding.later(terms.make("F", goal)))
            rest = diagrams.assign(rest, dict.fromkeys({variable, *waiting}, True))
        return rest, tuple(dict.fromkeys(found))

    def _tidy(self, rest: Node) -> Node:
        """`rest` without terms that do not matter beside others, by implication.

        A term goes in favour of weaker ones, or because of stronger ones, only if these are pure:
        co-safety or safety, not both. What a pure term promises is kept or broken for good, so
        that breakpoints and guesses see the same promises as before.
        """
        done = self._tidied.get(rest)
        if done is None:
            done = self._tidied[rest] = self._drop_implied(rest)
        return done

    def _drop_implied(self, rest: Node) -> Node:
        unfolding, diagrams, implies = (
            self.unfolding,
            self.unfolding.diagrams,
            self.unfolding.implications.implies,
        )
        terms = {v: unfolding.term(v) for v in sorted(diagrams.support(rest))}
        pure = [v for v, t in terms.items() if self._is_pure(t)]
        for v, term in terms.items():
            weaker = [w for w in pure if w != v and implies(term, terms[w])]
            if weaker:
                with_v = diagrams.assign(rest, {v: True, **dict.fromkeys(weaker, True)})
                without = diagrams.assign(rest, {v: False})
                if diagrams.implies(with_v, diagrams.assign(without, dict.fromkeys(weaker, True))):
                    rest = without
                    continue
            stronger = [w for w in pure if w != v and implies(terms[w], term)]
            if stronger:
                with_v = diagrams.assign(rest, {v: True})
                without = diagrams.assign(rest, {v: False, **dict.fromkeys(stronger, False)})
                if diagrams.implies(
                    diagrams.assign(with_v, dict.fromkeys(stronger, False)), without
                ):
                    rest = with_v
        return rest

    def _is_pure(self, term: Term) -> bool:
        return not (self.terms.has_least[term] and self.terms.has_greatest[term])

    def start(self, left: Node, goals: Goals) -> Serving:
        """The state that begins a round; `left`, settled, is what must hold from now on."""
        rest = self.unfolding.step(left)
        for source, promise in self._promises(left):
            return Serving(rest, goals, -source, promise)
        return Serving(rest, goals, 1, self._waiting(goals[0]) if goals else TRUE)

    def resume(self, rest: Node, goals: Goals) -> Serving:
        """As `start`, for what must hold from now on as it unfolds."""
        if self.is_safety(rest):
            return Serving(rest, goals, 1, self._waiting(goals[0]) if goals else TRUE)
        return Serving(rest, goals, 0, self.unfolding.rewrite(rest, self._promise))

    def _promises(self, left: Node) -> list[tuple[int, Node]]:
        """What the sources in `left` have promised: each by its number, as it unfolds."""
        found = self._sources.get(left)
        if found is None:
            found = []
            if not self.is_safety(self.unfolding.step(left)):
                promise = self._tidy(self.unfolding.rewrite(left, self._promise))
                found = self._by_source(left, promise)
            self._sources[left] = found
        return found

    def _by_source(self, left: Node, promise: Node) -> list[tuple[int, Node]]:
        """`promise` split by the formulas G x of `left` whose sub-formulas it is made of.

        Where these have no promise in common, each can be waited for in its turn. What is not of
        one of them has number 0; a promise of two sources makes them one, and so does any other
        part of `left` that may promise "F b or F c" again and again: whoever is waited for must not
        change with what is promised just now, or else some turn might be passed over for ever.
        """
        diagrams = self.unfolding.diagrams
        owner = self._owners(left)
        support = sorted(diagrams.support(promise))
        source = {v: owner.get(self.unfolding.term(v), 0) for v in support}
        for clause in diagrams.cover(diagrams.negate(promise)):
            joined = {source[v] for v, _ in clause}
            source.update((v, min(joined)) for v in support if source[v] in joined)
        parts = []
        for number in sorted(set(source.values())):
            others = dict.fromkeys((v for v in support if source[v] != number), True)
            parts.append((number, self.unfolding.step(diagrams.assign(promise, others))))
        return parts

    def _owners(self, left: Node) -> dict[Term, int]:
        """The source of each promise that the clauses of `left` with a ν-operator may make."""
        diagrams, terms = self.unfolding.diagrams, self.terms
        groups: list[tuple[frozenset[Term], list[Term]]] = []
        for clause in diagrams.cover(diagrams.negate(left)):
            parts = [self.unfolding.term(v) for v, _ in clause]
            if all(self._is_pure(t) for t in parts):
                continue
            own = frozenset[Term]().union(*map(self._promising, parts))
            sources = parts if len(parts) == 1 and terms.universal[parts[0]] else []
            met = [group for group in groups if group[0] & own]
            groups = [group for group in groups if not group[0] & own]
            own = own.union(*(others for others, _ in met))
            groups.append((own, [*sources, *(t for _, found in met for t in found)]))
        return {t: min(sources, default=0) for own, sources in groups for t in own}

    def _promising(self, term: Term) -> frozenset[Term]:
        """The sub-formulas of `term` with µ-operators, and what they promise."""
        found = self._parts.get(term)
        if found is None:
            found = frozenset().union(*map(self._promising, self.terms.operands[term]))
            if self.terms.has_least[term]:
                found |= {term, self._promise(term)} - {YES}
            self._parts[term] = found
        return found

    def is_safety(self, state: Node) -> bool:
        """Whether nothing that must come is left in `state`."""
        return not any(self.terms.has_least[t] for t in self.unfolding.left_over(state))

    def _waiting(self, goal: Term) -> Node:
        return self.unfolding.unfold(self.terms.make("F", goal))

    def _promise(self, term: Term) -> Term:
        """`term`[all ν true]µ."""
        found = self._promised.get(term)
        if found is None:
            terms = self.terms
            name = terms.operator[term]
            inner = [self._promise(t) for t in terms.operands[term]]
            if name in GREATEST:
                found = YES
            elif name in ("and", "or"):
                found = terms.both(inner) if name == "and" else terms.either(inner)
            else:
                found = terms.make(name, *inner) if inner else term
            self._promised[term] = found
        return found

    def successors(self, state: Serving) -> list[tuple[Serving, bool, Node]]:
        """The edges of `state`: target, whether it accepts, letters. Missing letters are fatal."""
        edges = []
        for (rest, promise), guard in self.split(state.rest, state.promise).items():
            left, goals = self.settle(rest, state.goals)
            unfolded = self.unfolding.step(left)
            waiting = self.unfolding.step(self._tidy(promise))
            if unfolded == FALSE or waiting == FALSE:
                continue
            if goals != state.goals:
                edges.append((self.start(left, goals), False, guard))
            elif waiting == TRUE or (state.turn <= 0 and self.is_safety(unfolded)):
                edges.extend(self._pass_on(left, goals, state.turn, guard))
            else:
                edges.append((Serving(unfolded, goals, state.turn, waiting), False, guard))
        return edges

    def _pass_on(
        self, left: Node, goals: Goals, turn: int, guard: Node
    ) -> list[tuple[Serving, bool, Node]]:
        """The edges to the sources after `turn`: the first one that the letter does not meet."""
        edges = []
        diagrams = self.unfolding.diagrams
        rest = self.unfolding.step(left)
        for source, promise in self._promises(left):
            if turn <= 0 and source > -turn:
                return [(Serving(rest, goals, -source, promise), False, guard)]
        for following in range(max(turn, 0) + 1, len(goals) + 1):
            goal = goals[following - 1]
            met = self._letters_meeting(goal)
            stop = diagrams.minus(guard, met)
            if stop != FALSE:
                edges.append((Serving(rest, goals, following, self._waiting(goal)), False, stop))
            guard = diagrams.conj(guard, met)
        if guard != FALSE:
            edges.append((self.start(left, goals), True, guard))
        return edges

    def _letters_meeting(self, goal: Term) -> Node:
        """The letters that make F `goal` true at once."""
        found = self._met.get(goal)
        if found is None:
            found = self._met[goal] = FALSE
            for (rest,), guard in self.split(self._waiting(goal)).items():
                if self.unfolding.step(rest) == TRUE:
                    found = self.unfolding.diagrams.disj(found, guard)
            self._met[goal] = found
        return found

    def step(self, state: Serving) -> tuple[Term, Node] | None:
        """The goal whose turn it is and what is left of it, if it takes several steps."""
        if state.turn <= 0 or not state.goals or self._free:
            return None
        goal = state.goals[state.turn - 1]
        written = goal in self.written and self.terms.has_least[goal]
        return (goal, state.promise) if written else None

    def pending(self, state: Serving) -> Node | None:
        """What the turn waits for, unless the state's ξ and goals already say it."""
        if state.turn <= 0:
            told = self.unfolding.diagrams.implies(state.rest, state.promise)
        else:
            fresh = not state.goals or state.promise == self._waiting(state.goals[state.turn - 1])
            told = fresh and len(state.goals) < 2
        return None if told else state.promise
