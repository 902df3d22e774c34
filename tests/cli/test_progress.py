"""The line that moves while training: what is on it, and that it fits."""

import io
import re
import sys
import time

import numpy as np
import pytest

from tests.report.runs import plan
from tiloilc.cli.progress import Progress
from tiloilc.learn import Watched
from tiloilc.learn.run.tally import Tally


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def watched(step: int = 30_000, **metrics: list[float | None]) -> Watched:
    tally = Tally.empty(2, 5)
    tally.episodes += 4
    tally.visits += 6
    tally.violations += 1
    tally.occupancy[:, 0] = 10
    tally.occupancy[:, 2] = 5
    return Watched(step, 60_000, False, tally, metrics or None)


def use_terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """From now on standard error is one; not as a fixture: pytest captures anew for the test."""
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr("tiloilc.cli.progress.REDRAW", 0)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    return stream


@pytest.mark.parametrize(
    ("columns", "shown", "left_out"),
    [
        (
            160,
            ["learning", "━", "visits/episode 1.50", "violations 25%", "█ ▄", "10 steps/s  50:0"],
            [],
        ),
        (85, ["learning", "30,000/60,000", "1.50", "stages", "left"], ["━", "violations"]),
        (60, ["learning", "30,000/60,000", "left"], ["stages", "visits"]),
        (20, ["30,000/60,000"], ["learning"]),
        (5, [], ["30"]),
    ],
)
def test_the_moving_line_fits_its_terminal(
    monkeypatch: pytest.MonkeyPatch,
    columns: int,
    shown: list[str],
    left_out: list[str],
) -> None:
    terminal = use_terminal(monkeypatch)
    monkeypatch.setenv("COLUMNS", str(columns))
    with Progress(plan(), quiet=False) as progress:
        progress.first, progress.began = 0, time.monotonic() - 3001  # so long for half of it
        progress.watch(watched())
        line = terminal.getvalue()
    assert len(line) < columns
    assert all(text in line for text in shown), line
    assert not any(text in line for text in left_out), line


def test_no_speed_is_claimed_before_a_step_was_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = use_terminal(monkeypatch)
    monkeypatch.setenv("COLUMNS", "200")
    with Progress(plan(), quiet=False) as progress:
        progress.watch(watched())
        assert "left" not in terminal.getvalue()
        progress.began -= 100_000
        progress.watch(watched(30_100))
        assert re.search(r"0 steps/s  83\d\d:\d\d:\d\d left$", terminal.getvalue())


def test_what_is_judged_stays_and_the_rest_is_overwritten(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    terminal = use_terminal(monkeypatch)
    with Progress(plan(), quiet=False) as progress:
        progress.watch(watched(100))
        progress.watch(watched(200, accepting_visits=[1.0, 3.0], violation_rate=[0.0, 0.5]))
    moving, kept = terminal.getvalue().split("\r")[0], terminal.getvalue().split("\r")[-1]
    assert "100/60,000" in moving
    assert kept.startswith("     200 steps  greedy visits   2.00 (worst seed 1.00)")
    assert kept.endswith("\n")


def test_where_nothing_can_move_only_what_is_judged_is_written(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with Progress(plan(), quiet=False) as progress:
        progress.watch(watched(100))
        progress.watch(watched(200, accepting_visits=[1.0], violation_rate=[0.0]))
    (line,) = stream.getvalue().splitlines()
    assert "200 steps" in line
    assert np.isfinite(float(line.split("greedy visits")[1].split()[0]))
