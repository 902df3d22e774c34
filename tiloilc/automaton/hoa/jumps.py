"""Nondeterministic edges as ε-jumps, where waiting is deterministic and nothing is lost by it.

An edge from a state that waits into the deterministic part becomes a jump to a state there that
has this edge: tools expand jumps into such edges, and this finds them again.

Whoever jumps must not be made to jump too early: an agent in a random world has to see how things
turned out first. So for every edge into the deterministic part, the state that went on waiting must
have one later on that accepts as much. Otherwise `subsets.py` waits with all possibilities.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import permutations

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import Draft, Row, components, keep, reachable
from tiloilc.automaton.hoa.general import Limited
from tiloilc.automaton.reduction.reduce import MAX_PAIRS, Inclusion

Letters = dict[int, Node]
"""Letters by target; they may overlap."""


def with_jumps(limited: Limited, diagrams: Diagrams) -> Draft | None:
    """The automaton with its `free` states deterministic but for jumps.

    None where a free state leads to two free ones on one letter, or to jump early loses something.
    States keep their numbers as names; states that are made for jumps have the numbers after those.
    """
    count = len(limited.fixed)
    waits = [{t: guard for t, guard in row.items() if t >= count} for row in limited.free]
    leaves = [{t: guard for t, guard in row.items() if t < count} for row in limited.free]
    for row in waits:
        seen = FALSE
        for guard in row.values():
            if diagrams.conj(seen, guard) != FALSE:
                return None
            seen = diagrams.disj(seen, guard)
    if not _Postponed(limited, waits, leaves, diagrams).all():
        return None
    return _Jumps(limited, waits, leaves, diagrams).draft()


def union(guards: Iterable[Node], diagrams: Diagrams) -> Node:
    """The letters of all `guards`."""
    together = FALSE
    for guard in guards:
        together = diagrams.disj(together, guard)
    return together


def cannot_wait(wait: Letters, diagrams: Diagrams) -> Node:
    """The letters that are in none of `wait`."""
    return diagrams.negate(union(wait.values(), diagrams))


class _Postponed:
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
        pairs = dict.fromkeys(self._rivals())
        work = list(dict.fromkeys(self._first()))
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


class _Jumps:
    """The draft in the making."""

    def __init__(
        self, limited: Limited, waits: list[Letters], leaves: list[Letters], diagrams: Diagrams
    ) -> None:
        self.limited = limited
        self.waits = waits
        self.leaves = leaves
        self.diagrams = diagrams
        self.rows: list[Row] = [*limited.fixed, *({} for _ in limited.free)]
        self.made: dict[frozenset[tuple[int, Node]], int] = {}
        self.by_origin = [self._by_origin(row) for row in limited.fixed]
        self.weights: dict[Node, float] = {FALSE: 0.0, TRUE: 1.0}

    def draft(self) -> Draft:
        """All states, of which those that nothing leads to are left out."""
        count = len(self.limited.fixed)
        targets: list[tuple[int, ...]] = [()] * len(self.rows)
        for i, wait in enumerate(self.waits):
            row, jumps = self._row(wait, self.leaves[i])
            self.rows[count + i] = row
            targets[count + i] = jumps
        targets += [()] * (len(self.rows) - len(targets))
        names = tuple(partial(str, q) for q in range(len(self.rows)))
        whole = Draft(tuple(self.rows), tuple(targets), self.limited.initial, names)
        graph = [whole.targets(q) for q in range(len(self.rows))]
        return keep(whole, reachable(graph, [whole.initial]))

    def _by_origin(self, row: Row) -> Letters:
        letters: Letters = {}
        for (target, _), guard in row.items():
            n = self.limited.origin[target]
            letters[n] = self.diagrams.disj(letters.get(n, FALSE), guard)
        return letters

    def _row(self, wait: Letters, leave: Letters) -> tuple[Row, tuple[int, ...]]:
        """The edges of a state, and its jumps, which have all of `leave` that is no edge.

        While it cannot wait, one of its ways out is an edge.
        """
        diagrams = self.diagrams
        now = cannot_wait(wait, diagrams)
        jumps = self._chosen(leave, now)
        open_ways = self._uncovered(leave, jumps)
        row: Row = {(t, False): guard for t, guard in wait.items()}
        free = now
        for ways in (open_ways, leave):
            for target, guard in ways.items():
                here = diagrams.conj(guard, free)
                if here != FALSE:
                    key = (target, False)
                    row[key] = diagrams.disj(row.get(key, FALSE), here)
                    free = diagrams.minus(free, here)
        rest = {
            t: self._without(guard, row.get((t, False), FALSE)) for t, guard in open_ways.items()
        }
        while any(guard != FALSE for guard in rest.values()):
            jumps.append(self._new(rest))
        return row, tuple(sorted(set(jumps)))

    def _without(self, guard: Node, taken: Node) -> Node:
        return self.diagrams.minus(guard, taken)

    def _chosen(self, leave: Letters, now: Node) -> list[int]:
        """Fixed states that have edges of `leave` only, as few as are found to have what is needed.

        On letters of `now`, all but one way.
        """
        diagrams, origin = self.diagrams, self.limited.origin
        ways = {origin[t]: guard for t, guard in leave.items()}
        fitting = [
            t
            for t, row in enumerate(self.by_origin)
            if row
            and row.keys() <= ways.keys()
            and all(diagrams.implies(guard, ways.get(n, FALSE)) for n, guard in row.items())
        ]
        diagrams.budget.tick()
        chosen: list[int] = []
        while True:
            needed = self._needed(self._uncovered(leave, chosen), now)
            gains = [
                sum(
                    self._weight(diagrams.conj(needed.get(n, FALSE), guard))
                    for n, guard in self.by_origin[t].items()
                )
                for t in fitting
            ]
            best = max(range(len(fitting)), key=lambda i: (gains[i], -i), default=None)
            if best is None or not gains[best]:
                break
            chosen.append(fitting[best])
        for t in list(chosen):
            fewer = [c for c in chosen if c != t]
            if self._needed(self._uncovered(leave, fewer), now) == self._needed(
                self._uncovered(leave, chosen), now
            ):
                chosen = fewer
        return chosen

    def _uncovered(self, leave: Letters, jumps: list[int]) -> Letters:
        """The ways that none of `jumps` has."""
        left = dict(leave)
        for t in jumps:
            for target in leave:
                guard = self.by_origin[t].get(self.limited.origin[target], FALSE)
                left[target] = self.diagrams.minus(left[target], guard)
        return left

    def _needed(self, left: Letters, now: Node) -> Letters:
        """By origin, of the ways in `left` those that must be jumps: on `now`, all but one."""
        diagrams, needed = self.diagrams, {}
        for target, guard in left.items():
            others = FALSE
            for other, letters in left.items():
                if other != target:
                    others = diagrams.disj(others, letters)
            lone = diagrams.minus(diagrams.conj(guard, now), others)
            needed[self.limited.origin[target]] = diagrams.minus(guard, lone)
        return needed

    def _weight(self, letters: Node) -> float:
        """The share of all letters that are in `letters`."""
        if letters not in self.weights:
            _, low, high = self.diagrams.parts(letters)
            self.weights[letters] = (self._weight(low) + self._weight(high)) / 2
        return self.weights[letters]

    def _new(self, rest: Letters) -> int:
        """A state with as many ways of `rest` as a deterministic one can have; they are taken."""
        row: dict[int, Node] = {}
        seen = FALSE
        for target, guard in rest.items():
            here = self.diagrams.minus(guard, seen)
            if here != FALSE:
                row[target] = here
                seen = self.diagrams.disj(seen, here)
                rest[target] = self.diagrams.minus(guard, here)
        key = frozenset(row.items())
        if key not in self.made:
            self.made[key] = len(self.rows)
            self.rows.append({(t, False): guard for t, guard in row.items()})
        return self.made[key]
