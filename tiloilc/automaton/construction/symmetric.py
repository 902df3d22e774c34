"""The states that wait and the jumps they may take, for all of LTL.

Esparza, Křetínský and Sickert (One Theorem to Rule Them All, LICS 2018; JACM 2020, theorem 5.2): a
word w satisfies φ just if there are a set M of µ-sub-formulas and a set N of ν-sub-formulas with

1. some suffix w_i satisfies af(φ, w_0 … w_{i-1})[M]ν, a safety formula,
2. w satisfies GF(ψ[N]µ) for every ψ in M,
3. some suffix satisfies G(ψ[M]ν) for every ψ in N.

`ψ[M]ν` takes the µ-operators of M as kept for ever (F p: true, U: W, M: R) and the others as
false; `ψ[N]µ` takes the ν-operators of N as true and weakens the others' promise to one that must
come (G p: false, W: U, R: M). A waiting state tracks af(φ, ·); a jump guesses M and N and goes to
a deterministic state for the rest, see `breakpoint.py`. Waiting ends without a jump as soon as what
is left is of the recurrence class.

Only guesses that can matter are made: M contains a µ-formula only if it stands below a ν-operator
(any other promise is kept or broken after finitely many letters, so one can wait for it) and is
met while [M]ν is applied; N contains a ν-formula only if it is met while [N]µ is applied to M.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from tiloilc.automaton.bdd import FALSE, TRUE, Node
from tiloilc.automaton.construction.breakpoint import Breakpoints, Goals, Serving
from tiloilc.automaton.construction.terms import GREATEST, LEAST, NO, YES, Term, Terms
from tiloilc.automaton.construction.unfolding import Unfolding


class Waiting(NamedTuple):
    """A state that tracks what is left: the word must satisfy `rest` and GF of each goal."""

    rest: Node
    goals: Goals


State = Waiting | Serving


class Symmetric:
    """All states of the automaton of one formula.

    `eager`: the deterministic part takes over at the recurrence class, so that no jump is needed
    there; otherwise only at co-safety, safety and goals, which may take fewer states.
    """

    def __init__(self, unfolding: Unfolding, eager: bool = True) -> None:
        self.unfolding = unfolding
        self.terms = unfolding.terms
        self.breakpoints = Breakpoints(unfolding)
        self._ends_waiting = self._in_class if eager else self._simple

    def initial(self, formula: Term) -> State | None:
        """The first state; None if the formula is false by propositional reasoning."""
        return self._enter(self.unfolding.later(formula), ())

    def _enter(self, rest: Node, goals: Goals) -> State | None:
        left, goals = self.breakpoints.settle(rest, goals)
        unfolded = self.unfolding.step(left)
        if unfolded == FALSE:
            return None
        if self._ends_waiting(unfolded):
            return self.breakpoints.start(unfolded, goals)
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
        """The states that check the guess from now on, of which one must be chosen."""
        terms, unfolding = self.terms, self.unfolding
        rest = unfolding.rewrite(state.rest, guess.weaken_top)
        for term in guess.always():
            kept = unfolding.unfold(terms.make("G", guess.weaken(term)))
            rest = unfolding.diagrams.conj(rest, kept)
        goals = [guess.goal(term) for term in guess.again()]
        if rest == FALSE or NO in goals:
            return []
        wanted = [goal for goal in goals if goal != YES]
        together = tuple(dict.fromkeys([*state.goals, *wanted]))
        return [self.breakpoints.start(part, together) for part in self._alternatives(rest)]

    def _alternatives(self, rest: Node) -> list[Node]:
        """`rest` as alternatives that a jump may choose from: one of `G a | G b` each.

        Only where each is what some formulas say that, once true, stay true. Which of them become
        true is settled in the long run, so that nobody has to guess what chance decides later.
        """
        unfolding, diagrams = self.unfolding, self.unfolding.diagrams
        lower = [v for v in sorted(diagrams.support(rest)) if v >= unfolding.letters]
        lasting = {v for v in lower if self.terms.universal[unfolding.term(v)]}
        chosen = {frozenset(v for v, _ in cube if v in lasting) for cube in diagrams.cover(rest)}
        largest = [kept for kept in chosen if not any(kept < other for other in chosen)]
        parts = []
        for kept in sorted(largest, key=sorted):
            part = diagrams.assign(rest, dict.fromkeys(lasting - kept, False))
            said = TRUE
            for v in sorted(kept):
                said = diagrams.conj(said, unfolding.unfold(unfolding.term(v)))
            if not diagrams.implies(said, part):
                return [rest]
            parts.append(part)
        return parts

    def _guesses(self, rest: Node) -> Iterator[Guess]:
        """All complete guesses for `rest`, each made only as far as it matters."""
        roots = self.unfolding.left_over(rest)
        open_guesses: list[dict[Term, bool]] = [{}]
        while open_guesses:
            self.unfolding.diagrams.budget.tick()
            guess = Guess(self.terms, open_guesses.pop())
            best = self.unfolding.rewrite(rest, guess.weaken)
            unknown = guess.first_unknown(roots)
            if unknown is None:
                yield guess
            elif best != FALSE:
                open_guesses.append({**guess.chosen, unknown: True})
                open_guesses.append({**guess.chosen, unknown: False})


class Guess:
    """M and N, perhaps still in part: `chosen[t]` says whether t is in its set.

    What is not chosen yet counts as in, which makes every result as weak as it can become.
    """

    def __init__(self, terms: Terms, chosen: Mapping[Term, bool]) -> None:
        self.terms = terms
        self.chosen = chosen
        self._weak: dict[tuple[Term, bool], Term] = {}
        self._strong: dict[Term, Term] = {}

    def again(self) -> list[Term]:
        """M, in the written order."""
        return self._in(LEAST)

    def always(self) -> list[Term]:
        """N, in the written order."""
        return self._in(GREATEST)

    def _in(self, operators: frozenset[str]) -> list[Term]:
        chosen = sorted(self.chosen.items())
        return [t for t, is_in in chosen if is_in and self.terms.operator[t] in operators]

    def weaken_top(self, term: Term) -> Term:
        """`term`[M]ν outside every ν-operator: what only must come once is not guessed."""
        return self.weaken(term, below=False)

    def weaken(self, term: Term, below: bool = True) -> Term:
        """`term`[M]ν; `below`: it stands below a ν-operator."""
        terms = self.terms
        if not terms.has_least[term]:
            return term
        key = (term, below)
        if key not in self._weak:
            name, operands = terms.operator[term], terms.operands[term]
            if name in LEAST and not self.chosen.get(term, below):
                result = NO
            elif name == "F":
                result = YES
            else:
                inner = [self.weaken(t, below or name in GREATEST) for t in operands]
                result = self._rebuild({"U": "W", "M": "R"}.get(name, name), inner)
            self._weak[key] = result
        return self._weak[key]

    def strengthen(self, term: Term) -> Term:
        """`term`[N]µ."""
        terms = self.terms
        if not terms.has_greatest[term]:
            return term
        if term not in self._strong:
            name, operands = terms.operator[term], terms.operands[term]
            if name in GREATEST and self.chosen.get(term, True):
                result = YES
            elif name == "G":
                result = NO
            else:
                inner = [self.strengthen(t) for t in operands]
                result = self._rebuild({"W": "U", "R": "M"}.get(name, name), inner)
            self._strong[term] = result
        return self._strong[term]

    def _rebuild(self, name: str, inner: list[Term]) -> Term:
        if name in ("and", "or"):
            return self.terms.both(inner) if name == "and" else self.terms.either(inner)
        return self.terms.make(name, *inner)

    def goal(self, term: Term) -> Term:
        """The q with GF(`term`[N]µ) = GF q, for a µ-formula `term`."""
        name, operands = self.terms.operator[term], self.terms.operands[term]
        if name in "XFU":
            return self.goal(operands[-1])
        if name == "M":
            return self.terms.both([self.strengthen(t) for t in operands])
        strong = self.strengthen(term)
        return strong if strong == term else self.goal(strong)

    def first_unknown(self, roots: list[Term]) -> Term | None:
        """A sub-formula met by this guess's substitutions that is not chosen yet."""
        seen: set[tuple[Term, str]] = set()
        work = [(t, "top") for t in reversed(roots)]
        work += [(t, "below") for t in self.always()] + [(t, "again") for t in self.again()]
        while work:
            term, where = work.pop()
            if (term, where) in seen:
                continue
            seen.add((term, where))
            name, operands = self.terms.operator[term], self.terms.operands[term]
            if where == "again":
                where, operands = "strong", operands if name == "M" else operands[-1:]
            elif where == "strong" and name in GREATEST:
                if term not in self.chosen:
                    return term
                if self.chosen[term] or name == "G":
                    continue
            elif where != "strong" and name in LEAST:
                if where == "below" and term not in self.chosen:
                    return term
                if name == "F" or not self.chosen.get(term, False):
                    continue
            elif where == "top" and name in GREATEST:
                where = "below"
            work.extend((t, where) for t in reversed(operands) if self._matters(t, where))
        return None

    def _matters(self, term: Term, where: str) -> bool:
        """Whether the substitution changes anything in `term`."""
        strong = where == "strong"
        return self.terms.has_greatest[term] if strong else self.terms.has_least[term]
