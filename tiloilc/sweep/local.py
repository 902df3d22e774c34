"""The engine of one machine: a process a job, some at a time, one thread each."""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass

from tiloilc.sweep.engine import Event, Started
from tiloilc.sweep.work import PAUSE, Outcome, Process, Work, begin


@dataclass(frozen=True)
class Local:
    """At most `workers` processes at a time."""

    workers: int

    def results(self, works: Sequence[Work]) -> Generator[Event, None, None]:
        """Do the jobs here. When it is closed, running ones write a checkpoint and end."""
        waiting, running = list(reversed(works)), list[Process]()
        try:
            while waiting or running:
                while waiting and len(running) < self.workers:
                    begun = begin(waiting.pop())
                    if isinstance(begun, Outcome):
                        yield begun
                    else:
                        running.append(begun)
                        yield Started(begun.work.id)
                for process in list(running):
                    outcome = process.outcome()
                    if outcome is not None:
                        running.remove(process)
                        yield outcome
                yield None
                time.sleep(PAUSE)
        finally:
            for process in running:
                process.interrupt()  # all of them first, so that they end side by side
            for process in running:
                process.end()
