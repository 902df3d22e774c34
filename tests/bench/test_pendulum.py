"""SAC without any logic: it learns Pendulum, and does as well as Stable-Baselines3's."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
import torch

from tiloilc.bench import pendulum
from tiloilc.bench.pendulum import OURS, THEIRS, Point
from tiloilc.evaluate import generator, read, summarise

UNTRAINED = -700
"""Doing nothing returns about −900 on the first of these episodes."""


def test_everybody_is_judged_on_the_same_episodes() -> None:
    idle = np.zeros((2, 3, 1))
    first, second = pendulum.judge(lambda seen: idle, 2, 3)
    assert first == second
    assert first < UNTRAINED
    assert pendulum.judge(lambda seen: idle[:1], 1, 3) == (first,)


def test_both_learners_run_a_few_steps_and_leave_no_logs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(pendulum, "EVERY", 125)
    ours = list(pendulum.train_ours(125, 0, 2, batch_size=8))
    theirs = list(pendulum.train_theirs(125, 0))
    assert [(point.step, len(point.returns)) for point in ours] == [(125, 2)]
    assert [(point.step, len(point.returns)) for point in theirs] == [(125, 1)]
    again = list(pendulum.train_ours(125, 0, 2, batch_size=8))
    assert again == ours
    assert list(tmp_path.glob("SB3-*")) == []


def test_a_record_a_seed_tells_what_was_run() -> None:
    points = [Point(2000, (-900.0, -800.0)), Point(4000, (-150.0, -140.0))]
    first, second = (r.fields for r in pendulum.record(OURS, 3, points, 12.34))
    assert (first["seed"], second["seed"]) == (3, 4)
    assert (first["return"], second["return"]) == (-150, -140)
    assert second["curve"] == [{"step": 2000, "return": -800}, {"step": 4000, "return": -140}]
    assert first["seconds"] == 12.3
    assert first["steps"] == 4000
    assert first["overrides"]["gamma"] == 0.99  # type: ignore[index,call-overload]


@pytest.mark.slow
def test_our_sac_learns_pendulum() -> None:
    """Each seed swings up in one of four looks: by how much one of them is off its best at a given
    step is a matter of last digits, which processors round differently.
    """
    seeds = zip(*(point.returns for point in pendulum.train_ours(8000, 0, 2)), strict=True)
    assert min(max(looks) for looks in seeds) > -200


def test_the_committed_page_is_that_of_the_records(root: Path) -> None:
    records = read(root / "results" / "sac" / "pendulum.jsonl.gz")
    page = (root / "docs" / "pendulum.md").read_text(encoding="utf-8")
    assert page == pendulum.pendulum_page(records), "run `make results`"


def test_the_recorded_returns_have_overlapping_intervals(root: Path) -> None:
    records = read(root / "results" / "sac" / "pendulum.jsonl.gz")
    intervals = []
    for algorithm in (OURS, THEIRS):
        found = pendulum.returns(records, algorithm)
        assert len(found) == pendulum.SEEDS
        summary = summarise(found, generator())
        assert summary is not None
        intervals.append(summary.mean_interval)
    ours, theirs = intervals
    assert ours.low <= theirs.high
    assert theirs.low <= ours.high


@pytest.fixture(autouse=True)
def one_thread() -> None:
    torch.set_num_threads(1)
