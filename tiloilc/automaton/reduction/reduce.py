"""The passes that make an automaton smaller and keep its language, and their order."""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle, islice

from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft
from tiloilc.automaton.reduction.exits import cut_exits
from tiloilc.automaton.reduction.follow import drop_jumps
from tiloilc.automaton.reduction.jumps import delay_jumps
from tiloilc.automaton.reduction.merge import merge_by_language
from tiloilc.automaton.reduction.quotient import quotient
from tiloilc.automaton.reduction.stay import accept_waiting
from tiloilc.automaton.reduction.trial import merge_by_trial
from tiloilc.automaton.reduction.trim import trim

MAX_ROUNDS = 20
"""The passes shrink the automaton until nothing changes; this bounds the rounds all the same."""

Pass = Callable[[Draft, Diagrams], Draft]

PASSES: tuple[Pass, ...] = (
    trim,
    quotient,
    delay_jumps,
    trim,
    drop_jumps,
    merge_by_language,
    trim,
    merge_by_trial,
    trim,
    accept_waiting,
    trim,
    cut_exits,
)
"""In this order, again and again while they shrink the automaton."""


def reduce(draft: Draft, diagrams: Diagrams) -> Draft:
    """Run the passes in turn until none of them makes the automaton smaller."""
    size, idle = _size(draft), 0
    for step in islice(cycle(PASSES), MAX_ROUNDS * len(PASSES)):
        draft = step(draft, diagrams)
        before, size = size, _size(draft)
        idle = idle + 1 if size == before else 1
        if idle == len(PASSES):
            break
    return draft


def _size(draft: Draft) -> tuple[int, int, int]:
    return (
        len(draft.rows),
        sum(len(targets) for targets in draft.jumps),
        sum(len(row) for row in draft.rows),
    )
