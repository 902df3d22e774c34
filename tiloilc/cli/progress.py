"""Training as one line that moves, or as a line now and then where nothing can move."""

from __future__ import annotations

import shutil
import time
from typing import TYPE_CHECKING

from tiloilc.cli.line import MovingLine, clock

if TYPE_CHECKING:
    from tiloilc.learn import Metrics, Watched
    from tiloilc.plan import Plan

BLOCKS = " ▁▂▃▄▅▆▇█"
REDRAW = 0.2
"""Seconds between two states of the moving line."""


class Progress(MovingLine):
    """Writes to standard error: a bar with stages, visits, violations, speed and time left."""

    def __init__(self, plan: Plan, quiet: bool) -> None:
        super().__init__(quiet)
        self.live = [b for b in plan.ldba.states if b != plan.ldba.sink]
        self.began = self.drawn = time.monotonic()
        self.first: int | None = None

    def watch(self, seen: Watched) -> None:
        """Show where training is."""
        now = time.monotonic()
        if self.first is None:
            self.first = seen.step
        if self.quiet:
            return
        if seen.metrics is not None:
            self.write(self._judged(seen, seen.metrics), keep=True)
        elif self.moves and now - self.drawn >= REDRAW:
            columns = shutil.get_terminal_size().columns
            self.write(self._bar(seen, columns), keep=False)
            self.drawn = now

    def _judged(self, seen: Watched, metrics: Metrics) -> str:
        visits = [v for v in metrics["accepting_visits"] if v is not None]
        violations = [v for v in metrics["violation_rate"] if v is not None]
        mean, worst = sum(visits) / len(visits), min(visits)
        return (
            f"{seen.step:>8,} steps  greedy visits {mean:6.2f} (worst seed {worst:.2f})"
            f"  violations {sum(violations) / len(violations):4.0%}"
            f"  stages {self._stages(seen)}  {self._speed(seen)}"
        )

    def _bar(self, seen: Watched, columns: int) -> str:
        """The moving line: as many of its parts as fit, the first ones before the others."""
        done = round(24 * seen.step / seen.steps)
        tally = seen.tally
        episodes = max(int(tally.episodes.sum()), 1)
        what = "exploring" if seen.exploring else "learning"
        parts = (
            (1, f"{what:>9}"),
            (6, f"[{'━' * done}{' ' * (24 - done)}]"),
            (0, f"{seen.step:,}/{seen.steps:,}"),
            (3, f" visits/episode {tally.visits.sum() / episodes:.2f}"),
            (5, f" violations {tally.violations.sum() / episodes:.0%}"),
            (4, f" stages {self._stages(seen)}"),
            (2, f" {self._speed(seen)}"),
        )
        for most in range(len(parts), -1, -1):
            line = " ".join(text for rank, text in parts if rank < most)
            if len(line) < columns:
                return line.strip()
        return ""

    def _stages(self, seen: Watched) -> str:
        """How much time is spent in each live automaton state, as a small histogram."""
        counts = seen.tally.occupancy.sum(0)[self.live]
        most = max(int(counts.max()), 1)
        return "".join(BLOCKS[round(8 * int(c) / most)] for c in counts)

    def _speed(self, seen: Watched) -> str:
        taken = seen.step - (self.first or 0)
        if taken <= 0:
            return "speed not known yet"
        speed = taken / max(time.monotonic() - self.began, 1e-3)
        return f"{speed:,.0f} steps/s  {clock((seen.steps - seen.step) / speed)} left"
