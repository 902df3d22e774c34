"""Each state of an automaton in words: what was seen, what is to be done, what loses for ever.

Everything here is read off the automaton, never off the formula, so that it holds for automata
from files as well; `tests/plan/test_telling.py` checks each claim on random automata.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.draft import reachable
from tiloilc.automaton.guards import as_diagram, text_between
from tiloilc.automaton.ldba import Ldba, StateId
from tiloilc.automaton.limits import Budget
from tiloilc.plan.model import Stages

Way = Literal["lost", "on", "aside", "back", "to", "stays"]
"""What a letter does to the stage: `to` is said of accepting states, where a new round begins."""

SOMETHING = re.compile(r"(?<![!\w\"])[\w\"]")
"""In a guard: a proposition without a negation."""

ORDER: tuple[Way, ...] = ("lost", "on", "to", "aside", "back", "stays")


@dataclass(frozen=True, slots=True)
class Case:
    """One row: where the letters of `guard` lead, if no row before has them."""

    guard: str
    way: Way
    target: StateId


@dataclass(frozen=True, slots=True)
class Decision:
    """One ε-jump: the agent may read a letter as in `jump`; by each guard to the live `target`."""

    jump: StateId
    ways: tuple[tuple[str, StateId], ...]


class Teller:
    """What can be said of the states of one automaton."""

    def __init__(self, ldba: Ldba, stages: Stages) -> None:
        self.ldba = ldba
        self.stages = stages
        self._diagrams = Diagrams(Budget())
        self._rows = [self._row(b) for b in ldba.states]

    def cases(self, b: StateId) -> list[Case]:
        """Where the letters lead without jumps: the first row whose guard holds says it.

        The last row is `else`, unless there is just one.
        """
        row = self._rows[b]
        lost = row.get(self.ldba.sink, FALSE) if self.ldba.sink is not None else FALSE
        found = []
        for target, node in row.items():
            way = self._way(b, target)
            high = node if way == "lost" else self._diagrams.disj(node, lost)
            found.append(Case(self._text(node, high), way, target))
        found.sort(key=lambda case: (ORDER.index(case.way), case.target))
        if len(found) > 1:
            found[-1] = Case("else", found[-1].way, found[-1].target)
        return found

    def decisions(self, b: StateId) -> list[Decision]:
        """The ε-jumps of `b`."""
        found = []
        for jump in self.ldba.jump_targets[b]:
            live = [t for t in sorted(self._rows[jump]) if t != self.ldba.sink]
            ways = tuple((self._text(node := self._rows[jump][t], node), t) for t in live)
            found.append(Decision(jump, ways))
        return found

    def loses(self, b: StateId) -> str:
        """The letters that lose for ever in `b` whatever the agent decides; empty if none do."""
        lost = self._lost(b)
        return "" if lost == FALSE else self._text(lost, lost)

    def seen(self, b: StateId) -> list[str]:
        """What was read on every way to `b`, in this order; nothing is said of the start.

        One formula for each state that every way to `b` passes (a dominator): of the letters that
        lead into it for the first time, and of none that would have been lost instead. Left out
        are those in which nothing is seen: of any letter, or of absences only.
        """
        if b == self.ldba.initial:
            return []
        texts = [self._entered(c) for c in self._passed(b)]
        return [text for text in texts if SOMETHING.search(text) and text != "true"]

    def decided(self, b: StateId) -> list[StateId]:
        """The jumps without which there is no way to `b`."""
        found = []
        for jump in sorted({target for _, target in self.ldba.jumps}):
            follow = [
                sorted({t for r in readers if r != jump or r == c for t in self._rows[r]})
                for c, readers in enumerate(self._readers)
            ]
            if b not in reachable(follow, [self.ldba.initial]):
                found.append(jump)
        return found

    def needs(self, b: StateId) -> str:
        """What must be read in `b` for acceptance to be reached; empty if there are other ways.

        A formula of the letters that lead to a higher stage or to acceptance, of letters that do
        not lose. Nothing is said of accepting states.
        """
        onward = self._onward(b)
        if not onward or self._has_another_way(b, onward):
            return ""
        letters = FALSE
        for reader in self._readers[b]:
            for target, node in self._rows[reader].items():
                if target in onward:
                    letters = self._diagrams.disj(letters, node)
        return self._text(letters, self._diagrams.disj(letters, self._lost(b)))

    def must_decide(self, b: StateId) -> bool:
        """Whether acceptance is reached from `b` by one of its jumps only."""
        onward = self._onward(b)
        if not onward or self._has_another_way(b, onward):
            return False
        return not any(target in onward for target in self._rows[b])

    def _onward(self, b: StateId) -> set[StateId]:
        """The states of a higher stage, or accepting, that one letter may lead to."""
        if b in self.ldba.accepting:
            return set()
        return {t for t in self._targets[b] if self._is_onward(b, t)}

    def _has_another_way(self, b: StateId, onward: set[StateId]) -> bool:
        """Whether acceptance can be reached from `b` without a step from `b` to `onward`."""
        follow = [
            [t for t in targets if c != b or t not in onward]
            for c, targets in enumerate(self._targets)
        ]
        return bool(self.ldba.accepting & reachable(follow, [b]))

    def accepts_while_not_lost(self, b: StateId) -> bool:
        """Whether from `b` on every live state is accepting."""
        live = reachable(self._targets, [b])
        return b in self.ldba.accepting and live <= self.ldba.accepting

    def cannot_be_lost(self, b: StateId) -> bool:
        """Whether no way from `b` leads to the sink, without jumps."""
        follow = [list(row) for row in self._rows]
        return self.ldba.sink not in reachable(follow, [b])

    @cached_property
    def _targets(self) -> list[list[StateId]]:
        """The live states that one letter may lead to, by δ or by a jump."""
        sink = self.ldba.sink
        reached = [{t for reader in row for t in self._rows[reader]} for row in self._readers]
        return [sorted(t for t in row if t != sink) for row in reached]

    @cached_property
    def _readers(self) -> list[tuple[StateId, ...]]:
        """The states whose edges a letter may take: the state itself, and its jumps."""
        jumps = self.ldba.jump_targets
        return [() if b == self.ldba.sink else (b, *jumps[b]) for b in self.ldba.states]

    def _row(self, b: StateId) -> dict[StateId, Node]:
        row: dict[StateId, Node] = {}
        for edge in self.ldba.outgoing[b]:
            node = as_diagram(self._diagrams, edge.guard)
            row[edge.target] = self._diagrams.disj(row.get(edge.target, FALSE), node)
        return row

    def _lost(self, b: StateId) -> Node:
        """The letters that lose in `b` and in all that it may jump to."""
        if self.ldba.sink is None:
            return FALSE
        lost = self._rows[b].get(self.ldba.sink, FALSE)
        for jump in self.ldba.jump_targets[b]:
            lost = self._diagrams.conj(lost, self._rows[jump].get(self.ldba.sink, FALSE))
        return lost

    def _is_onward(self, b: StateId, target: StateId) -> bool:
        higher = self.stages.index[target] > self.stages.index[b]
        return target != b and (higher or target in self.ldba.accepting)

    def _way(self, b: StateId, target: StateId) -> Way:
        if target == self.ldba.sink:
            return "lost"
        if target == b:
            return "stays"
        if b in self.ldba.accepting:
            return "to"
        if self._is_onward(b, target):
            return "on"
        return "back" if self.stages.index[target] < self.stages.index[b] else "aside"

    def _passed(self, b: StateId) -> list[StateId]:
        """The states that every way from the start to `b` passes, `b` last, the start left out."""
        start = self.ldba.initial
        passed = []
        for c in self.ldba.states:
            without = [[] if a == c else targets for a, targets in enumerate(self._targets)]
            if c == b or (c != start and b not in reachable(without, [start])):
                passed.append(c)
        # Of two of them, the one that the other is only reached by stands first.
        return sorted(passed, key=lambda c: sum(self._precedes(d, c) for d in passed))

    def _precedes(self, first: StateId, second: StateId) -> bool:
        without = [[] if a == first else targets for a, targets in enumerate(self._targets)]
        return first != second and second not in reachable(without, [self.ldba.initial])

    def _sources(self, b: StateId) -> list[StateId]:
        """The states from which `b` may be entered for the first time."""
        without = [[] if a == b else targets for a, targets in enumerate(self._targets)]
        before = reachable(without, [self.ldba.initial])
        return [c for c in sorted(before) if c != b and b in self._targets[c]]

    def _entered(self, b: StateId) -> str:
        """The letters that lead into `b` for the first time.

        Letters that would be lost wherever they could do so do not matter.
        """
        letters, lost = FALSE, TRUE
        for source in self._sources(b):
            for reader in self._readers[source]:
                letters = self._diagrams.disj(letters, self._rows[reader].get(b, FALSE))
            lost = self._diagrams.conj(lost, self._lost(source))
        return self._text(letters, self._diagrams.disj(letters, lost))

    def _text(self, low: Node, high: Node) -> str:
        return text_between(self._diagrams, low, high, self.ldba.propositions)
