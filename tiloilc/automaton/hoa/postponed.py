"""Whether a jump may always be taken later: what makes jumps good for agents in a random world.

Whoever jumps must not be made to jump too early: an agent has to see how things turned out first.
So for every edge into the deterministic part, the state that went on waiting must have one later on
that accepts as much, unless the run that was missed never accepts again.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice, permutations

from tiloilc.automaton.bdd import FALSE, Diagrams, Node
from tiloilc.automaton.draft import Draft, components
from tiloilc.automaton.hoa.general import Limited
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion

Letters = dict[int, Node]
"""Letters by target; they may overlap."""


def union(guards: Iterable[Node], diagrams: Diagrams) -> Node:
    """The letters of all `guards`."""
    together = FALSE
    for guard in guards:
        together = diagrams.disj(together, guard)
    return together


def cannot_wait(wait: Letters, diagrams: Diagrams) -> Node:
    """The letters that are in none of `wait`."""
    return diagrams.negate(union(wait.values(), diagrams))


class Postponed:
    """Whether everything that one may go to can be gone to later, too, or something as good."""

    def __init__(
        self, limited: Limited, waits: list[Letters], leaves: list[Letters], diagrams: Diagrams
    ) -> None:
        self.limited = limited
        self.count = len(limited.fixed)
        self.waits = waits
        self.leaves = leaves
        self.diagrams = diagrams
        self.few = True
        fixed = Draft(limited.fixed, ((),) * self.count, 0, ())
        self.inclusion = Inclusion(fixed, diagrams, self._asked())

    def all(self) -> bool:
        """Also true where it would take too long to find out."""
        known = self.few and self.inclusion.complete
        return not known or (self._choices() and self._later())

    def _first(self) -> Iterator[tuple[int, int]]:
        """Free states with the fixed ones that could have been gone to instead."""
        for wait, leave in zip(self.waits, self.leaves, strict=True):
            for other, letters in wait.items():
                for target, guard in leave.items():
                    if self.diagrams.conj(letters, guard) != FALSE:
                        yield other - self.count, target

    def _steps(self, missed: int) -> Iterator[tuple[int, bool, Node]]:
        """Where the run that was not taken goes on, whether that accepts, on which letters."""
        for (target, mark), guard in self.limited.fixed[missed].items():
            self.diagrams.budget.tick()
            yield target, mark, guard

    def _asked(self) -> list[tuple[int, int]]:
        """All pairs of fixed states whose languages may have to be compared, unless too many."""
        pairs = dict.fromkeys(islice(self._rivals(), MAX_PAIRS + 1))
        work = list(dict.fromkeys(islice(self._first(), MAX_PAIRS + 1)))
        seen = set(work)
        while work:
            if len(pairs) + len(seen) > MAX_PAIRS:
                self.few = False
                return []
            state, missed = work.pop()
            self.diagrams.budget.tick()
            for target, _, guard in self._steps(missed):
                for other, letters in self.leaves[state].items():
                    if self.diagrams.conj(letters, guard) != FALSE:
                        pairs[target, other] = None
                for other, letters in self.waits[state].items():
                    pair = (other - self.count, target)
                    if pair not in seen and self.diagrams.conj(letters, guard) != FALSE:
                        seen.add(pair)
                        work.append(pair)
        return list(pairs)

    def _choices(self) -> bool:
        """Where one cannot wait, one of the possibilities must be as good as all others."""
        diagrams = self.diagrams
        for wait, leave in zip(self.waits, self.leaves, strict=True):
            now = cannot_wait(wait, diagrams)
            open_ways = {t: diagrams.conj(guard, now) for t, guard in leave.items()}
            left = union(open_ways.values(), diagrams)
            for best, guard in open_ways.items():
                worse = guard
                for other, letters in open_ways.items():
                    if diagrams.conj(letters, worse) == FALSE or other == best:
                        continue
                    if not self.inclusion.holds(other, best):
                        worse = diagrams.minus(worse, letters)
                left = diagrams.minus(left, worse)
            if left != FALSE:
                return False
        return True

    def _rivals(self) -> Iterator[tuple[int, int]]:
        """Fixed states of which one must be chosen on some letter, both ways round."""
        for wait, leave in zip(self.waits, self.leaves, strict=True):
            now = cannot_wait(wait, self.diagrams)
            for a, b in permutations(leave, 2):
                self.diagrams.budget.tick()
                both = self.diagrams.conj(leave[a], leave[b])
                if self.diagrams.conj(both, now) != FALSE:
                    yield a, b

    def _later(self) -> bool:
        """Whether every missed run is made up for, unless it never accepts again."""
        order = list(dict.fromkeys(self._first()))
        index = {pair: i for i, pair in enumerate(order)}
        graph: list[list[tuple[int, bool]]] = []
        for pair in order:
            later = self._still_missed(*pair)
            if later is None:
                return False
            for following, _ in later:
                if following not in index:
                    index[following] = len(order)
                    order.append(following)
            graph.append([(index[following], mark) for following, mark in later])
        component = components([[t for t, _ in edges] for edges in graph])
        return not any(
            mark and component[i] == component[t]
            for i, edges in enumerate(graph)
            for t, mark in edges
        )

    def _still_missed(self, state: int, missed: int) -> list[tuple[tuple[int, int], bool]] | None:
        """What is not made up for one letter later, and whether the missed run accepted there.

        None if it is too late on some letter.
        """
        later = []
        for target, mark, guard in self._steps(missed):
            left = guard
            for other, letters in self.leaves[state].items():
                met = self.diagrams.conj(letters, left) != FALSE
                if met and self.inclusion.holds(target, other):
                    left = self.diagrams.minus(left, letters)
            for other, letters in self.waits[state].items():
                if self.diagrams.conj(letters, left) != FALSE:
                    later.append(((other - self.count, target), mark))
                    left = self.diagrams.minus(left, letters)
            if left != FALSE:
                return None
        return later
