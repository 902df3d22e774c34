"""A job on a machine that has none of the files of the one where the sweep runs."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.sweep.made import experiments, task
from tiloilc.demos import load
from tiloilc.driver import labeller, load_plan, write_build
from tiloilc.plan import digest
from tiloilc.sweep.parcel import pack, unpack
from tiloilc.sweep.ray import moved
from tiloilc.sweep.work import Work

LABELS = """\
def far(observations):
    return observations[:, 0] >= 3
"""


@pytest.fixture
def build(tmp_path: Path) -> Path:
    """The build of a task with a predicate in Python."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "labels.py").write_text(LABELS)
    path = task(home)
    text = path.read_text().replace("a: x >= 3 and y == 0", "a: {python: 'labels.py:far'}")
    path.write_text(text)
    (one,) = experiments(path)
    write_build(one.task, home / "build")
    return home / "build"


def test_a_parcel_makes_the_same_plan_where_nothing_else_is(tmp_path: Path, build: Path) -> None:
    parcel, before = pack(build), load_plan(build)
    demos = load(build / "demos.npz")
    shutil.rmtree(tmp_path / "home")
    there = unpack(parcel, build, tmp_path / "away")
    plan = load_plan(there)  # finds every input that it needs, unchanged
    assert digest(plan) == digest(before)
    for ours, theirs in zip(load(there / "demos.npz").episodes, demos.episodes, strict=True):
        assert np.array_equal(ours.observations, theirs.observations)
    observations = np.array([[2.0, 0.0], [3.0, 0.0]], dtype=np.float32)
    assert list(labeller(plan)(observations)) == [0, 1]


def test_where_the_build_is_seen_nothing_is_unpacked(tmp_path: Path, build: Path) -> None:
    assert unpack(pack(build), build, tmp_path / "away") == build
    assert not (tmp_path / "away").exists()


def test_a_build_of_that_name_but_of_another_plan_is_not_used(tmp_path: Path, build: Path) -> None:
    parcel = pack(build)
    (build / "plan.json").write_text("{}")
    assert unpack(parcel, build, tmp_path / "away") == tmp_path / "away" / "build"


def test_a_job_whose_folder_cannot_be_made_here_has_another(
    tmp_path: Path, build: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    (tmp_path / "file").write_text("")
    work = Work("job", str(tmp_path / "file" / "job"), str(build), (), 1)
    here = moved(work, pack(build))
    assert here.folder == str(tmp_path / "tmp" / "tiloilc-sweep" / "job")
    assert here.build == work.build
