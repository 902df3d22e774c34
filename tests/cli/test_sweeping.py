"""What a sweep tells as it goes: lines that stay, one that moves, and how long it will take."""

from __future__ import annotations

import io
import sys
import time
from pathlib import Path

import pytest

from tests.cli.test_progress import Terminal
from tests.sweep.made import experiments, task
from tiloilc.cli.line import clock
from tiloilc.cli.sweeping import SweepProgress
from tiloilc.sweep import Outcome, Started, Sweep, jobs_of


@pytest.fixture
def sweep(tmp_path: Path) -> Sweep:
    """Three jobs of one seed."""
    found = experiments(task(tmp_path), seeds=3, seeds_per_job=1)
    return Sweep(found, jobs_of(found, [()]), tmp_path / "runs")


def ended(id: str, seconds: float, problem: str = "") -> Outcome:
    return Outcome(id, (), problem, (), seconds)


def test_every_job_has_a_line_when_it_begins_and_when_it_ends(
    sweep: Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    one, two, _ = (job.id for job in sweep.jobs)
    with SweepProgress(sweep, quiet=False) as progress:
        progress.began -= 60.2  # as if one after the other
        for event in (Started(one), None, ended(one, 60.2), Started(two), ended(two, 1, "bad")):
            progress.watch(event)
    assert stream.getvalue().splitlines() == [
        "begun   corridor tiloil seed 0",
        "done    corridor tiloil seed 0  1:00  (1 of 3 done, 0 running, 2:00 left)",
        "begun   corridor tiloil seed 1",
        "failed  corridor tiloil seed 1  0:01  (2 of 3 done, 1 failed, 0 running, 1:00 left)",
    ]


def test_jobs_side_by_side_take_less_time(sweep: Sweep) -> None:
    one, two, three = (job.id for job in sweep.jobs)
    progress = SweepProgress(sweep, quiet=True)
    progress.began -= 60.0
    for event in (Started(one), Started(two), Started(three), ended(one, 60.0)):
        progress.watch(event)
    for id in (two, three):
        progress.running[id] = time.monotonic() - 30.0
    assert progress.left() == pytest.approx(30.0, abs=1.0)


def test_where_a_line_can_move_it_is_the_last_and_fits(
    sweep: Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr("tiloilc.cli.sweeping.REDRAW", 0)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "20")
    monkeypatch.delenv("NO_COLOR", raising=False)
    with SweepProgress(sweep, quiet=False) as progress:
        progress.watch(Started(sweep.jobs[0].id))
    assert terminal.getvalue() == "begun   corridor tiloil seed 0\n0 of 3 done, 1 runn\r" + (
        " " * 19 + "\r\n"
    )


def test_nothing_is_told_to_who_wants_quiet(
    sweep: Sweep, capsys: pytest.CaptureFixture[str]
) -> None:
    with SweepProgress(sweep, quiet=True) as progress:
        progress.watch(Started(sweep.jobs[0].id))
        progress.watch(ended(sweep.jobs[0].id, 1.0))
    assert capsys.readouterr() == ("", "")


def test_hours_are_told_where_there_are_any() -> None:
    assert [clock(s) for s in (0.4, 59.6, 3599, 3600, 90061)] == [
        "0:00", "1:00", "59:59", "1:00:00", "25:01:01",
    ]  # fmt: skip
