"""Waiting with all possibilities, where a state does not say which one it will be.

The states that wait are sets of states of the file (the subset construction), and one may jump to
any deterministic member at any time (Courcoubetis and Yannakakis, The Complexity of Probabilistic
Verification, JACM 1995). Nobody has to guess what chance decides later, whatever the file was like:
a member that accepts from here on with probability one is still there when that is known.
"""

from __future__ import annotations

from functools import partial

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import Draft, Row
from tiloilc.automaton.hoa.general import Limited
from tiloilc.automaton.reduction.inclusion import MAX_PAIRS, Inclusion

Members = tuple[int, ...]
"""States of the file's automaton, ascending."""


def with_subsets(limited: Limited, names: tuple[str, ...], diagrams: Diagrams) -> Draft:
    """The automaton with sets of states for those that wait.

    `names` are those of the states; a set is called by its members. Raises CompileError AUT305.
    """
    return _Subsets(limited, names, diagrams).draft()


class _Subsets:
    def __init__(self, limited: Limited, names: tuple[str, ...], diagrams: Diagrams) -> None:
        self.limited = limited
        self.names = names
        self.diagrams = diagrams
        self.count = len(limited.fixed)
        self.entry = limited.entry
        self.index: dict[Members, int] = {}
        self.order: list[Members] = []
        entered = sorted(q for q in self.entry.values() if q < self.count)
        pairs = [(a, b) for a in entered for b in entered if a != b]
        self.inclusion: Inclusion | None = None
        if 0 < len(pairs) <= MAX_PAIRS:
            fixed = Draft(limited.fixed, ((),) * self.count, 0, ())
            self.inclusion = Inclusion(fixed, diagrams, pairs)

    def draft(self) -> Draft:
        """All sets that can be reached, after the deterministic states."""
        rows: list[Row] = list(self.limited.fixed)
        jumps: list[tuple[int, ...]] = [()] * self.count
        initial = self._number((self.limited.initial,))
        for members in self.order:
            row: Row = {}
            for following, guard in self._successors(members):
                key = (self._number(following), False)
                row[key] = self.diagrams.disj(row.get(key, FALSE), guard)
            rows.append(row)
            jumps.append(tuple(q for q in members if q < self.count))
        names = [partial(str, self.names[q]) for q in range(self.count)]
        names += [partial(" or ".join, [self.names[q] for q in m]) for m in self.order]
        return Draft(tuple(rows), tuple(jumps), initial, tuple(names))

    def _number(self, members: Members) -> int:
        """The state for a set; a lone deterministic member is itself."""
        if len(members) == 1 and members[0] < self.count:
            return members[0]
        if members not in self.index:
            self.index[members] = self.count + len(self.order)
            self.order.append(members)
            self.diagrams.budget.states(self.count + len(self.order))
        return self.index[members]

    def _successors(self, members: Members) -> list[tuple[Members, Node]]:
        """The sets that `members` become, and on which letters."""
        parts: dict[frozenset[int], Node] = {frozenset(): TRUE}
        for q in members:
            for target, guard in self._edges(q):
                split: dict[frozenset[int], Node] = {}
                for found, letters in parts.items():
                    self.diagrams.budget.tick()
                    with_it = self.diagrams.conj(letters, guard)
                    without = self.diagrams.minus(letters, guard)
                    for key, part in ((found | {target}, with_it), (found, without)):
                        if part != FALSE:
                            split[key] = self.diagrams.disj(split.get(key, FALSE), part)
                parts = split
        return [(self._needed(found), guard) for found, guard in parts.items() if found]

    def _edges(self, q: int) -> list[tuple[int, Node]]:
        if q >= self.count:
            return list(self.limited.free[q - self.count].items())
        origin = self.limited.origin
        return [(self.entry[origin[t]], guard) for (t, _), guard in self.limited.fixed[q].items()]

    def _needed(self, found: frozenset[int]) -> Members:
        """Without deterministic members that accept no more than another one."""
        kept = sorted(found)
        if self.inclusion is not None:
            for q in [q for q in sorted(found, reverse=True) if q < self.count]:
                others = [t for t in kept if t != q and t < self.count]
                if any(self.inclusion.holds(q, t) for t in others):
                    kept.remove(q)
        return tuple(kept)
