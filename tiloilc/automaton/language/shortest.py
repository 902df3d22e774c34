"""Shortest words of a formula: stem and loop with as few letters as there can be.

For each number of positions the words that satisfy the formula are one diagram, over a variable for
each proposition at each position; the temporal operators are fixpoints, as in `ltl.lasso`. (This is
the idea of bounded model checking: Biere, Cimatti, Clarke and Zhu, TACAS 1999.)
"""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.limits import Budget
from tiloilc.diag import CompileError
from tiloilc.ltl import Lasso, nnf, subformulas
from tiloilc.ltl.ast import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
)

MAX_LETTERS = 6
MAX_VARIABLES = 48
MAX_STATES = 500
MAX_TICKS = 20_000
"""Beyond these the word that is known will do."""


def shortest_word(formula: Formula, propositions: Sequence[str], known: Lasso) -> Lasso:
    """A shortest word of `formula`, which `known` satisfies, with the fewest true propositions.

    Of equally short words one with a short loop. `known` itself where that would take too long.
    """
    normal, budget = nnf(formula), Budget.of_work(MAX_STATES, MAX_TICKS)
    try:
        for length in range(1, min(len(known.letters), MAX_LETTERS) + 1):
            if length * len(propositions) > MAX_VARIABLES:
                break
            for loop in range(1, length + 1):
                found = _Words(length, length - loop, propositions, budget).first(normal)
                if found is not None:
                    return Lasso(found[: length - loop], found[length - loop :])
    except CompileError:
        pass
    return known


class _Words:
    """All words with `length` letters, of which those from `back` on are the loop."""

    def __init__(self, length: int, back: int, propositions: Sequence[str], budget: Budget) -> None:
        self.length, self.back = length, back
        self.names = {name: i for i, name in enumerate(propositions)}
        self.diagrams = Diagrams(budget)

    def first(self, formula: Formula) -> tuple[int, ...] | None:
        """The letters of a word that satisfies `formula` with the fewest true propositions."""
        truth: dict[Formula, list[Node]] = {}
        for part in subformulas(formula):
            truth[part] = self._truth(part, [truth[child] for child in part.children])
        words = truth[formula][0]
        return None if words == FALSE else self._letters(self._lightest(words, {}))

    def _truth(self, part: Formula, of: list[list[Node]]) -> list[Node]:
        """At each position the words in which `part` holds there."""
        match part:
            case Constant(value):
                return [TRUE if value else FALSE] * self.length
            case Proposition(name):
                return [self._variable(i, name) for i in range(self.length)]
            case Not():
                return [self.diagrams.negate(node) for node in of[0]]
            case And():
                return self._joined(TRUE, of)
            case Or():
                return self._joined(FALSE, of)
            case Next():
                return self._after(of[0])
            case Eventually():
                return self._fixpoint(FALSE, of[0], [TRUE] * self.length)
            case Always():
                return self._fixpoint(TRUE, [FALSE] * self.length, of[0])
            case Until():
                return self._fixpoint(FALSE, of[1], of[0])
            case WeakUntil():
                return self._fixpoint(TRUE, of[1], of[0])
            case Release() | StrongRelease():
                both = [self.diagrams.conj(one, other) for one, other in zip(*of, strict=True)]
                start = TRUE if isinstance(part, Release) else FALSE
                return self._fixpoint(start, both, of[1])
        raise AssertionError(f"not in negation normal form: {part!r}")

    def _joined(self, start: Node, of: list[list[Node]]) -> list[Node]:
        join = self.diagrams.conj if start == TRUE else self.diagrams.disj
        result = [start] * self.length
        for operand in of:
            result = [join(one, other) for one, other in zip(result, operand, strict=True)]
        return result

    def _after(self, values: list[Node]) -> list[Node]:
        """What holds at the position after each: the last is followed by the loop."""
        return [*values[1:], values[self.back]]

    def _fixpoint(self, start: Node, now: list[Node], keep: list[Node]) -> list[Node]:
        """The fixpoint of v = now | keep & X v: least from false, greatest from true."""
        conj, disj = self.diagrams.conj, self.diagrams.disj
        value = [start] * self.length
        while True:
            later = self._after(value)
            following = [disj(n, conj(k, x)) for n, k, x in zip(now, keep, later, strict=True)]
            if following == value:
                return value
            value = following

    def _variable(self, position: int, name: str) -> Node:
        return self.diagrams.literal(position * len(self.names) + self.names[name])

    def _lightest(self, words: Node, done: dict[Node, tuple[int, int]]) -> int:
        """The variables that are true in a word of `words` with the fewest of them, as bits."""

        def best(node: Node) -> tuple[int, int]:
            if node == TRUE:
                return 0, 0
            if node not in done:
                variable, low, high = self.diagrams.parts(node)
                ways = []
                if low != FALSE:
                    ways.append(best(low))
                if high != FALSE:
                    count, bits = best(high)
                    ways.append((count + 1, bits | 1 << variable))
                done[node] = min(ways)
            return done[node]

        return best(words)[1]

    def _letters(self, bits: int) -> tuple[int, ...]:
        width = len(self.names)
        return tuple(bits >> i * width & ((1 << width) - 1) for i in range(self.length))
