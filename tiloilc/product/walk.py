"""An automaton walked by many agents at once, as tables (paper, definition 2.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError, Diagnostic

Int = NDArray[np.int64]

MAX_PROPOSITIONS = 16
"""The tables have a column for each letter; no task of the paper has more than 10."""


@dataclass(frozen=True, eq=False)
class Walk:
    """`options[b, letter]` are the states an agent in b may go to; [B, 2^|AP|, K].

    δ(b, letter) comes first, then the successors by each ε-jump, dead ones left out; the row is
    filled up with its first entry. `sink` is -1 if there is none.
    """

    options: Int
    accepting: NDArray[np.bool_]
    sink: int
    initial: int

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


def walk_tables(ldba: Ldba) -> Walk:
    """The tables of `ldba`. Raises CompileError JOB606 for more than MAX_PROPOSITIONS."""
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
    rows = [
        [
            _options(successor[[b, *ldba.jump_targets[b]], letter].tolist(), ldba.sink)
            for letter in letters
        ]
        for b in ldba.states
    ]
    width = max(len(entry) for row in rows for entry in row)
    options = np.array(
        [[entry + entry[:1] * (width - len(entry)) for entry in row] for row in rows]
    )
    accepting = np.zeros(len(ldba.states), dtype=np.bool_)
    accepting[sorted(ldba.accepting)] = True
    return Walk(options, accepting, -1 if ldba.sink is None else ldba.sink, ldba.initial)


def _options(reached: list[int], sink: int | None) -> list[int]:
    live = list(dict.fromkeys(b for b in reached if b != sink))
    return live or reached[:1]
