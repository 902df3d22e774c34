"""Nondeterministic edges as ε-jumps, where waiting is deterministic and nothing is lost by it.

An edge from a state that waits into the deterministic part becomes a jump to a state there that
has this edge: tools expand jumps into such edges, and this finds them again.

Only where waiting loses nothing (`reduction/follow.py`): whoever jumps must not be made to jump too
early, an agent has to see how things turned out first. Elsewhere `subsets.py` waits with all
possibilities.
"""

from __future__ import annotations

from functools import partial

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import Draft, Row, keep, on_cycles, reachable
from tiloilc.automaton.hoa.general import Limited
from tiloilc.automaton.reduction.follow import can_wait

Letters = dict[int, Node]
"""Letters by target; they may overlap."""

FEW = 40
"""Of more jumps from one state nobody asks whether one is too many."""


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
    draft = _Jumps(limited, waits, leaves, diagrams).draft()
    return draft if can_wait(draft, diagrams) else None


def _cannot_wait(wait: Letters, diagrams: Diagrams) -> Node:
    """The letters that are in none of `wait`."""
    left = TRUE
    for guard in wait.values():
        left = diagrams.minus(left, guard)
    return left


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
        fixed = Draft(limited.fixed, ((),) * len(limited.fixed), 0, (str,) * len(limited.fixed))
        _, self.looping = on_cycles(fixed)
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
        now = _cannot_wait(wait, diagrams)
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
            t: diagrams.minus(guard, row.get((t, False), FALSE)) for t, guard in open_ways.items()
        }
        while any(guard != FALSE for guard in rest.values()):
            jumps.append(self._new(rest))
            diagrams.budget.states(len(self.rows))
        return row, tuple(sorted(set(jumps)))

    def _chosen(self, leave: Letters, now: Node) -> list[int]:
        """Fixed states that have edges of `leave` only, as few as are found to have what is needed.

        On letters of `now`, all but one way. Of equals, one on a cycle: its jump can be waited for.
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
        left = leave
        while True:
            needed = self._needed(left, now)
            gains = [self._gain(t, needed) for t in fitting]
            rank = [(gain, self.looping[t], -t) for gain, t in zip(gains, fitting, strict=True)]
            best = max(range(len(rank)), key=rank.__getitem__, default=None)
            if best is None or not gains[best]:
                break
            chosen.append(fitting[best])
            left = self._uncovered(left, chosen[-1:])
        for t in list(chosen) if len(chosen) <= FEW else []:
            fewer = [c for c in chosen if c != t]
            if self._needed(self._uncovered(leave, fewer), now) == needed:
                chosen = fewer
        return chosen

    def _gain(self, jump: int, needed: Letters) -> float:
        """How much of `needed` is had by a jump."""
        self.diagrams.budget.tick()
        return sum(
            self._weight(self.diagrams.conj(needed.get(n, FALSE), guard))
            for n, guard in self.by_origin[jump].items()
        )

    def _uncovered(self, leave: Letters, jumps: list[int]) -> Letters:
        """The ways that none of `jumps` has."""
        left = dict(leave)
        for t in jumps:
            for target in leave:
                self.diagrams.budget.tick()
                guard = self.by_origin[t].get(self.limited.origin[target], FALSE)
                left[target] = self.diagrams.minus(left[target], guard)
        return left

    def _needed(self, left: Letters, now: Node) -> Letters:
        """By origin, of the ways in `left` those that must be jumps: on `now`, all but one."""
        diagrams = self.diagrams
        once, twice = FALSE, FALSE
        for guard in left.values():
            diagrams.budget.tick()
            twice = diagrams.disj(twice, diagrams.conj(once, guard))
            once = diagrams.disj(once, guard)
        lone = diagrams.minus(now, twice)
        origin = self.limited.origin
        return {origin[t]: diagrams.minus(guard, lone) for t, guard in left.items()}

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
            self.diagrams.budget.tick()
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
