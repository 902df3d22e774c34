"""Sets of words as diagrams over the letter at hand and what is left for later.

A formula's *unfolding* has the propositions of the letter as upper variables and, for each term t
that may be left over, "X t" as a lower variable. Fixing the letter and then putting the unfolding
of t for each X t is the step af(φ, letter) of Esparza, Křetínský and Sickert (A Unified Translation
of LTL into ω-Automata, JACM 2020, section 4). Equal diagrams are formulas that are equivalent by
propositional reasoning in unfolded form.
"""

from __future__ import annotations

from collections.abc import Callable

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.construction.implication import Implications
from tiloilc.automaton.construction.terms import NO, YES, Term, Terms


class Unfolding:
    """The unfoldings of one table of terms. Every diagram is monotone in the lower variables."""

    def __init__(self, terms: Terms, diagrams: Diagrams) -> None:
        self.terms = terms
        self.diagrams = diagrams
        self.implications = Implications(terms)
        self.letters = len(terms.propositions)
        self._variable_terms: list[Term] = []
        self._unfold: dict[Term, Node] = {}
        self._next: dict[Term, Node] = {NO: FALSE, YES: TRUE}
        self._step: dict[Node, Node] = {}
        self._step_suspended: dict[Node, Node] = {}
        self._before: dict[Node, Node] = {}

    def term(self, variable: int) -> Term:
        """The term t that the variable "X t" stands for."""
        return self._variable_terms[variable - self.letters]

    def later(self, term: Term) -> Node:
        """X `term`, as a diagram over the lower variables."""
        found = self._next.get(term)
        if found is None:
            if self.terms.operator[term] in ("and", "or"):
                found = self._fold(
                    self.terms.operator[term], [self.later(t) for t in self.terms.operands[term]]
                )
            else:
                variable = self.letters + len(self._variable_terms)
                self._variable_terms.append(term)
                found = self.diagrams.literal(variable)
            self._next[term] = found
        return found

    def unfold(self, term: Term) -> Node:
        """The unfolding of `term`, by the expansion laws."""
        found = self._unfold.get(term)
        if found is not None:
            return found
        name, operands = self.terms.operator[term], self.terms.operands[term]
        both, either = self.diagrams.conj, self.diagrams.disj
        if name[0] in "+-":
            found = self.diagrams.literal(int(name[1:]), name[0] == "+")
        elif name in ("true", "false"):
            found = TRUE if name == "true" else FALSE
        elif name in ("and", "or"):
            found = self._fold(name, [self.unfold(t) for t in operands])
        elif name == "X":
            found = self.later(operands[0])
        else:
            parts = [self.unfold(t) for t in operands]
            again = self.later(term)
            if name == "F":
                found = either(parts[0], again)
            elif name == "G":
                found = both(parts[0], again)
            elif name in ("U", "W"):
                found = either(parts[1], both(parts[0], again))
            else:
                found = both(parts[1], either(parts[0], again))
        self._unfold[term] = found
        return found

    def _fold(self, name: str, parts: list[Node]) -> Node:
        result, operation = TRUE, self.diagrams.conj
        if name == "or":
            result, operation = FALSE, self.diagrams.disj
        for part in parts:
            result = operation(result, part)
        return result

    def step(self, rest: Node) -> Node:
        """The unfolding of what `rest`, a diagram over the "X t", leaves for the next letter."""
        state = self.diagrams.substitute(rest, lambda v: self.unfold(self.term(v)), self._step)
        self._before.setdefault(state, rest)
        return state

    def step_suspended(self, rest: Node) -> Node:
        """As `step`, but what is true now if it is true later, as GF q, stays as it is."""

        def value(variable: int) -> Node:
            term = self.term(variable)
            suspended = self.terms.suspendable(term)
            return self.diagrams.literal(variable) if suspended else self.unfold(term)

        state = self.diagrams.substitute(rest, value, self._step_suspended)
        self._before.setdefault(state, rest)
        return state

    def folded(self, state: Node) -> Node | None:
        """A diagram over the "X t" of which `state` is the step, if one has come up."""
        return self._before.get(state)

    def rewrite(self, state: Node, rule: Callable[[Term], Term]) -> Node:
        """`state` with every "X t" replaced by X `rule(t)`."""
        return self.put(state, lambda term: self.later(rule(term)))

    def put(self, state: Node, value: Callable[[Term], Node]) -> Node:
        """`state` with every "X t" replaced by the diagram `value(t)`."""
        memo: dict[Node, Node] = {}
        below = self.letters

        def walk(f: Node) -> Node:
            variable, low, high = self.diagrams.parts(f)
            if f <= TRUE or variable >= below:
                return self.diagrams.substitute(f, lambda v: value(self.term(v)), memo)
            if f not in memo:
                letter = self.diagrams.literal(variable)
                if_true = self.diagrams.conj(letter, walk(high))
                if_false = self.diagrams.conj(self.diagrams.negate(letter), walk(low))
                memo[f] = self.diagrams.disj(if_true, if_false)
            return memo[f]

        return walk(state)

    def left_over(self, state: Node) -> list[Term]:
        """The terms t whose "X t" the diagram `state` depends on, in the order they came up."""
        below = self.letters
        return [self.term(v) for v in sorted(self.diagrams.support(state)) if v >= below]
