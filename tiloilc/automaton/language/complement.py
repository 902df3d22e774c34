"""Words that an automaton rejects, by complementing it on the way.

Blahoudek, Heizmann, Schewe, Strejček and Tsai (Complementing Semi-deterministic Büchi Automata,
TACAS 2016): runs in the deterministic part are checked (C) until they are guessed to be safe (S),
which means never to be marked again; the breakpoint set B makes sure that none is checked for ever.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.finish import draft_of
from tiloilc.automaton.language.words import accepting_lasso
from tiloilc.automaton.ldba import Ldba
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT, Budget
from tiloilc.automaton.reduction.jumps import waiting_states
from tiloilc.ltl import Lasso

GUESSED_AT_ONCE = 12
"""Runs that may be guessed safe in one step: one more doubles the work."""


class _Runs(NamedTuple):
    """All runs on a word so far: the waiting one, those checked, those safe, the breakpoint."""

    waiting: int | None
    checked: frozenset[int]
    safe: frozenset[int]
    due: frozenset[int]


def rejected_word(
    ldba: Ldba, *, max_states: int = MAX_STATES, timeout: float = TIMEOUT
) -> Lasso | None:
    """A short word that `ldba` rejects; None if it accepts every word.

    Where one jumps there must be no jumps any more. Raises CompileError AUT305.
    """
    return _Complement(ldba, Diagrams(Budget(max_states, timeout))).word()


class _Complement:
    """The complement of one automaton, built as far as it is walked."""

    def __init__(self, ldba: Ldba, diagrams: Diagrams) -> None:
        self.diagrams = diagrams
        self.draft = draft_of(ldba, diagrams)
        self.waiting = waiting_states(self.draft)
        assert all(t not in self.waiting for row in self.draft.jumps for t in row)
        self.seen: set[_Runs] = set()

    def word(self) -> Lasso | None:
        """A word of the complement."""
        none: frozenset[int] = frozenset()
        start = self.draft.initial
        if start in self.waiting:
            runs = _Runs(start, none, none, none)
        else:
            runs = _Runs(None, frozenset({start}), none, frozenset({start}))
        return accepting_lasso(runs, self.moves)

    def moves(self, runs: _Runs) -> Iterator[tuple[_Runs, bool, int]]:
        """Where `runs` lead on each class of letters; accepting: the breakpoint set is empty."""
        for guard in self._letter_classes(runs):
            letter = self.diagrams.first_letter(guard)
            for following in self._following(runs, guard):
                self.seen.add(following)
                self.diagrams.budget.states(len(self.seen))
                yield following, not runs.due, letter

    def _letter_classes(self, runs: _Runs) -> list[Node]:
        """Letters that all states of `runs` read alike."""
        sources = {*runs.checked, *runs.safe}
        if runs.waiting is not None:
            sources |= {runs.waiting, *self.draft.jumps[runs.waiting]}
        classes = [TRUE]
        for source in sorted(sources):
            for guard in self.draft.rows[source].values():
                parts = [
                    (self.diagrams.conj(c, guard), self.diagrams.minus(c, guard)) for c in classes
                ]
                classes = [part for pair in parts for part in pair if part != FALSE]
        return classes

    def _step(self, state: int, letters: Node) -> tuple[int, bool] | None:
        for edge, guard in self.draft.rows[state].items():
            if self.diagrams.implies(letters, guard):
                return edge
        return None

    def _following(self, runs: _Runs, letters: Node) -> Iterator[_Runs]:
        waiting = None
        checked, safe = set(), set()
        if runs.waiting is not None:
            for source in (runs.waiting, *self.draft.jumps[runs.waiting]):
                edge = self._step(source, letters)
                if edge is not None and edge[0] in self.waiting:
                    waiting = edge[0]
                elif edge is not None:
                    checked.add(edge[0])
        for source in runs.safe:
            edge = self._step(source, letters)
            if edge is not None and edge[1]:
                return
            if edge is not None:
                safe.add(edge[0])
        moved = [self._step(source, letters) for source in sorted(runs.checked)]
        checked |= {edge[0] for edge in moved if edge is not None}
        due = {e[0] for e in (self._step(q, letters) for q in sorted(runs.due)) if e is not None}
        candidates = sorted(checked - safe)
        most = len(candidates) if len(candidates) <= GUESSED_AT_ONCE else 0
        for size in range(most + 1):
            for guessed in combinations(candidates, size):
                self.diagrams.budget.tick()
                now_safe = frozenset(safe | set(guessed))
                now_checked = frozenset(checked - now_safe)
                still_due = frozenset(due - now_safe) if runs.due else now_checked
                yield _Runs(waiting, now_checked, now_safe, still_due)
