"""The class of a language in the safety–progress hierarchy, decided on a deterministic automaton.

An LDBA becomes a deterministic parity automaton whose states are the runs so far, oldest first
(Esparza, Křetínský, Raskin and Sickert, From LTL and Limit-Deterministic Büchi Automata to
Deterministic Parity Automata, TACAS 2017). On that, the classes are questions about its cycles
(Landweber 1969; Manna and Pnueli, A Hierarchy of Temporal Properties, PODC 1990).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import Draft, components, reachable, reversed_graph
from tiloilc.automaton.finish import draft_of
from tiloilc.automaton.ldba import Ldba
from tiloilc.automaton.limits import Budget
from tiloilc.diag import CompileError
from tiloilc.ltl.ast import Formula
from tiloilc.ltl.hierarchy import Hierarchy, syntactic_class

MAX_RUNS = 2_000
MAX_TICKS = 50_000
"""Of the parity automaton, and of the work for it: beyond, the class is not decided."""

Runs = tuple[int, ...]
"""The states of all runs, the oldest first. With one that stands still where it may jump."""


@dataclass(frozen=True, slots=True)
class _Parity:
    """A deterministic parity automaton without letters: (target, priority); least and even wins."""

    edges: tuple[tuple[tuple[int, int], ...], ...]

    @property
    def priorities(self) -> list[int]:
        """All priorities, ascending."""
        return sorted({p for row in self.edges for _, p in row})

    def cycles(self, least: int) -> list[int]:
        """The component of each state if only priorities from `least` on are followed."""
        return components([[t for t, p in row if p >= least] for row in self.edges])

    def on_cycle(self, least: int) -> set[int]:
        """The states on cycles whose least priority is `least`."""
        component = self.cycles(least)
        return {
            q
            for q, row in enumerate(self.edges)
            for t, p in row
            if p == least and component[q] == component[t]
        }

    def reaching(self, states: Iterable[int]) -> set[int]:
        """The states from which one of `states` can be reached."""
        return reachable(reversed_graph([[t for t, _ in row] for row in self.edges]), states)

    def winning(self, parity: int) -> set[int]:
        """The states from which some word has a least priority of this parity (0: is accepted)."""
        ends = (self.on_cycle(p) for p in self.priorities if p % 2 == parity)
        return self.reaching(chain.from_iterable(ends))


def hierarchy_class(ldba: Ldba, *, max_states: int = MAX_RUNS) -> Hierarchy:
    """The least class that the language of `ldba` is in.

    Raises CompileError AUT305 where a limit is reached.
    """
    diagrams = Diagrams(Budget.of_work(max_states, MAX_TICKS))
    parity = _Determiniser(ldba, diagrams).parity()
    return Hierarchy.least(
        safety=_is_closed(parity, 0),
        guarantee=_is_closed(parity, 1),
        recurrence=_is_limit(parity, 0),
        persistence=_is_limit(parity, 1),
    )


def formula_class(formula: Formula, ldba: Ldba) -> Hierarchy:
    """The class of `formula`, whose automaton is `ldba`; what its syntax shows if that is large."""
    try:
        return hierarchy_class(ldba)
    except CompileError:
        return syntactic_class(formula)


def _is_closed(parity: _Parity, wanted: int) -> bool:
    """Whether a word is in the language unless a beginning rules it out (1: of the complement)."""
    alive = parity.winning(wanted)
    return not any(parity.on_cycle(p) & alive for p in parity.priorities if p % 2 != wanted)


def _is_limit(parity: _Parity, wanted: int) -> bool:
    """Whether a cycle that contains a winning one wins (1: in the complement)."""
    for least in parity.priorities:
        if least % 2 != wanted:
            component = parity.cycles(least)
            losing = {component[q] for q in parity.on_cycle(least)}
            greater = [p for p in parity.priorities if p > least and p % 2 == wanted]
            if any(component[q] in losing for p in greater for q in parity.on_cycle(p)):
                return False
    return True


class _Determiniser:
    """Builds the parity automaton of one LDBA."""

    def __init__(self, ldba: Ldba, diagrams: Diagrams) -> None:
        self.diagrams = diagrams
        self.draft: Draft = draft_of(ldba, diagrams)
        self.lowest = 2 * len(self.draft.rows) + 3
        """A priority for steps at which nothing happens: odd, and no other is as great."""

    def parity(self) -> _Parity:
        start: Runs = (self.draft.initial,)
        index = {start: 0}
        order = [start]
        edges = []
        for runs in order:
            row: dict[tuple[int, int], None] = {}
            for letters in self._letter_classes(runs):
                following, priority = self._step(runs, letters)
                if following not in index:
                    index[following] = len(order)
                    order.append(following)
                    self.diagrams.budget.states(len(order))
                row[index[following], priority] = None
            edges.append(tuple(row))
        return _Parity(tuple(edges))

    def _letter_classes(self, runs: Runs) -> list[Node]:
        """Letters that all runs, and what they may jump to, read alike."""
        classes = [TRUE]
        for source in sorted({*runs, *(t for q in runs for t in self.draft.jumps[q])}):
            for guard in self.draft.rows[source].values():
                self.diagrams.budget.tick()
                parts = [
                    (self.diagrams.conj(c, guard), self.diagrams.minus(c, guard)) for c in classes
                ]
                classes = [part for pair in parts for part in pair if part != FALSE]
        return classes

    def _step(self, runs: Runs, letters: Node) -> tuple[Runs, int]:
        """What becomes of the runs; priority: of the oldest that ends (odd) or accepts (even)."""
        kept: dict[int, None] = {}
        priority = self.lowest
        for place, state in enumerate(runs):
            edge = self._edge(state, letters)
            if edge is None or edge[0] in kept:
                priority = min(priority, 2 * place + 1)
            else:
                kept[edge[0]] = None
                if edge[1]:
                    priority = min(priority, 2 * place + 2)
        for state in runs:
            for source in self.draft.jumps[state]:
                edge = self._edge(source, letters)
                if edge is not None:
                    kept.setdefault(edge[0])
        return tuple(kept), priority

    def _edge(self, state: int, letters: Node) -> tuple[int, bool] | None:
        for edge, guard in self.draft.rows[state].items():
            if self.diagrams.implies(letters, guard):
                return edge
        return None
