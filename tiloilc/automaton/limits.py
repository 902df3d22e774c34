"""How large and how slow a translation may become: a formula bomb ends in AUT305, not in a hang."""

from __future__ import annotations

import math
import time

from tiloilc.diag import CompileError, Diagnostic

MAX_STATES = 5_000
"""States of one automaton; nobody trains an agent on more, the paper's tasks need ten."""

TIMEOUT = 30.0
"""Seconds for one translation."""

NODES_PER_STATE = 200
"""Diagram nodes allowed for each state allowed: 5,000 states may fill about 300 MB."""

CLOCK_EVERY = 256
"""Ticks between two looks at the clock."""


class Budget:
    """What a translation has left. Every loop calls `tick`, every new state `state`."""

    def __init__(self, max_states: int = MAX_STATES, timeout: float = TIMEOUT) -> None:
        self.max_states = max_states
        self.timeout = timeout
        self._deadline = time.monotonic() + timeout
        self._ticks = 0
        self._max_ticks: int | None = None

    @classmethod
    def of_work(cls, max_states: int, max_ticks: int) -> Budget:
        """A budget without a clock: what it allows is the same on every machine."""
        return cls(max_states, math.inf).share(max_ticks)

    def share(self, max_ticks: int) -> Budget:
        """A budget for another attempt: so many ticks, the same end of time."""
        part = Budget(self.max_states, self.timeout)
        part._deadline = self._deadline
        part._max_ticks = max_ticks
        return part

    def release(self) -> None:
        """Allow as many ticks as time permits: the attempt has succeeded."""
        self._max_ticks = None

    @property
    def ticks(self) -> int:
        """Rounds of loops so far: the work done, as the same number on every machine."""
        return self._ticks

    @property
    def is_late(self) -> bool:
        """Whether the time is spent."""
        return time.monotonic() > self._deadline

    def tick(self) -> None:
        """Count one round of a loop. Raises CompileError AUT305 when the time is spent."""
        self._ticks += 1
        if self._ticks == self._max_ticks:
            raise too_large("it takes more work than was allowed")
        if self._ticks % CLOCK_EVERY == 0:
            self.look()

    def look(self) -> None:
        """Look at the clock, after much work of one tick. Raises CompileError AUT305."""
        if self.is_late:
            raise too_large(f"not done after {self.timeout:g} s")

    def states(self, count: int) -> None:
        """Allow `count` states. Raises CompileError AUT305."""
        self.tick()
        if count > self.max_states:
            states = "state" if self.max_states == 1 else "states"
            raise too_large(f"it has more than {self.max_states:_} {states}")

    def nodes(self, count: int) -> None:
        """Allow `count` diagram nodes. Raises CompileError AUT305."""
        self.tick()
        self.look()
        if count > self.max_states * NODES_PER_STATE:
            raise too_large("its states need more memory than the limit of states allows")


def too_large(problem: str) -> CompileError:
    """The error of a translation that reached a limit."""
    return CompileError(
        Diagnostic.of("AUT305", help="split the formula, or raise the limit", problem=problem)
    )
