"""A sweep as it goes: a line for each job, and one that moves where lines can."""

from __future__ import annotations

import shutil
import time
from typing import TYPE_CHECKING

from tiloilc.cli.line import MovingLine, clock

if TYPE_CHECKING:
    from tiloilc.sweep import Event, Job, Outcome, Sweep

REDRAW = 0.5
"""Seconds between two states of the moving line."""


class SweepProgress(MovingLine):
    """Writes to standard error what has begun and ended, how much is left, and how long it takes.

    The time left is told from the jobs that have ended: their seconds a step and seed.
    """

    def __init__(self, sweep: Sweep, quiet: bool) -> None:
        super().__init__(quiet)
        self.sweep = sweep
        self.jobs = {job.id: job for job in sweep.jobs}
        self.running: dict[str, float] = {}
        self.undone = set(self.jobs)
        self.told = False  # some engines do not know what has begun
        self.began = time.monotonic()
        self.failed = 0
        self.seconds, self.cost = 0.0, 0
        self.drawn = 0.0

    def watch(self, event: Event) -> None:
        """Tell of an event."""
        from tiloilc.sweep import Started

        match event:
            case None:
                pass
            case Started(id):
                self.told = True
                self.running[id] = time.monotonic()
                self.write(f"begun   {self._name(self.jobs[id])}", keep=True)
            case outcome:
                self._end(outcome)
        now = time.monotonic()
        if self.moves and now - self.drawn >= REDRAW:
            self.write(self.state()[: shutil.get_terminal_size().columns - 1], keep=False)
            self.drawn = now

    def _end(self, outcome: Outcome) -> None:
        job = self.jobs[outcome.id]
        self.running.pop(outcome.id, None)
        self.undone.discard(outcome.id)
        word = "failed" if outcome.problem else "done"
        if outcome.problem:
            self.failed += 1
        else:
            self.seconds += outcome.seconds
            self.cost += job.cost
        name, took = self._name(job), clock(outcome.seconds)
        self.write(f"{word:<8}{name}  {took}  ({self.state()})", keep=True)

    def state(self) -> str:
        """How much is done, runs and is left."""
        parts = [f"{len(self.jobs) - len(self.undone)} of {len(self.jobs)} done"]
        if self.failed:
            parts.append(f"{self.failed} failed")
        if self.told:
            parts.append(f"{len(self.running)} running")
        left = self.left()
        if left is not None:
            parts.append(f"{clock(left)} left")
        return ", ".join(parts)

    def left(self) -> float | None:
        """Seconds until all is done, if those before tell; None as long as none has ended."""
        if not self.cost or not self.undone:
            return None
        now = time.monotonic()
        spent = sum(now - began for began in self.running.values())
        cost = sum(self.jobs[id].cost for id in self.undone)
        aside = max(len(self.running), self.seconds / max(now - self.began, 1.0), 1.0)
        return max(cost * self.seconds / self.cost - spent, 0.0) / aside

    def _name(self, job: Job) -> str:
        one = self.sweep.experiments[job.number]
        return f"{one.plan.name} {one.words} {seeds_of(job.seeds)}"


def seeds_of(seeds: range) -> str:
    """The seeds in words."""
    if len(seeds) == 1:
        return f"seed {seeds.start}"
    return f"seeds {seeds.start}–{seeds.stop - 1}"
