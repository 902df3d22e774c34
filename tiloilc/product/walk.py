"""An automaton walked by many agents at once, as tables (paper, definition 2.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.spec.settings import Epsilon

Int = NDArray[np.int64]

MAX_PROPOSITIONS = 16
"""The tables have a column for each letter; no task of the paper has more than 10."""


@dataclass(frozen=True, eq=False)
class Walk:
    """`options[b, letter]` are the states an agent in b may go to; [B, 2^|AP|, K].

    δ(b, letter) comes first, then where each ε-jump leads, dead ends left out; the row is filled up
    with its first entry. Jumps that are free read the letter: they are successors of jump targets.
    Jumps that take a step (`costly`) read none: they are the targets themselves, seen from
    δ(b, letter). `sink` is -1 if there is none.
    """

    options: Int
    accepting: NDArray[np.bool_]
    sink: int
    initial: int
    costly: bool = False

    @property
    def states(self) -> int:
        """The number of automaton states."""
        return len(self.accepting)

    @property
    def width(self) -> int:
        """The greatest number of options, K."""
        return int(self.options.shape[2])

    @property
    def chooses(self) -> bool:
        """Whether there is ever more than one option."""
        return self.width > 1


def walk_tables(ldba: Ldba, epsilon: Epsilon = "free") -> Walk:
    """The tables of `ldba`, in which jumps are free or take a step of their own.

    Raises CompileError JOB606 for more than MAX_PROPOSITIONS.
    """
    if len(ldba.propositions) > MAX_PROPOSITIONS:
        raise CompileError(
            Diagnostic.of("JOB606", count=len(ldba.propositions), limit=MAX_PROPOSITIONS)
        )
    letters = np.arange(1 << len(ldba.propositions))
    successor = np.full((len(ldba.states), len(letters)), -1)
    for edge in ldba.edges:
        for cube in edge.guard:
            successor[edge.source, (letters & cube.mask) == cube.value] = edge.target
    assert (successor >= 0).all(), "an LDBA is complete"
    costly = epsilon == "step" and bool(ldba.jumps)
    jumps = ldba.jump_targets
    if costly:
        leaving = {b for b in ldba.states if jumps[b]}
        assert not leaving & ({t for _, t in ldba.jumps} | ldba.accepting), "one guess is enough"
        reached = [[(b, *jumps[b]) for b in row] for row in successor.tolist()]
    else:
        reached = [list(zip(*successor[[b, *jumps[b]]].tolist(), strict=True)) for b in ldba.states]
    rows = [[_options(entry, ldba.sink) for entry in row] for row in reached]
    width = max(len(entry) for row in rows for entry in row)
    options = np.array(
        [[entry + entry[:1] * (width - len(entry)) for entry in row] for row in rows]
    )
    accepting = np.zeros(len(ldba.states), dtype=np.bool_)
    accepting[sorted(ldba.accepting)] = True
    sink = -1 if ldba.sink is None else ldba.sink
    return Walk(options, accepting, sink, ldba.initial, costly)


def _options(reached: Sequence[int], sink: int | None) -> list[int]:
    live = list(dict.fromkeys(b for b in reached if b != sink))
    return live or list(reached[:1])
