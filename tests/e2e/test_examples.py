"""The examples do what their texts say."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.e2e.conftest import Run
from tests.e2e.test_readme import blocks
from tests.e2e.test_readme import run as run_block

EXAMPLES = (
    "own_environment",
    "own_demonstrations",
    "imported_automaton",
    "exported_policy",
    "own_algorithm",
    "third_party",
)


@pytest.fixture
def copied(
    root: Path, tmp_path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> Path:
    """A copy of the example that the test names, installed beside it if it is a distribution."""
    ignored = shutil.ignore_patterns("__pycache__", "build", "runs", "*.egg-info")
    copy = shutil.copytree(root / "examples" / request.param, tmp_path / "copy", ignore=ignored)
    if (copy / "pyproject.toml").exists():
        source = shutil.copytree(copy, tmp_path / "source")  # building leaves files there
        target = installed(source, tmp_path / "installed")
        monkeypatch.setenv("PYTHONPATH", str(target), prepend=os.pathsep)
    return copy


def installed(source: Path, target: Path) -> Path:
    """`target`, into which `source` has been installed without looking for anything else."""
    flags = ["--quiet", "--no-index", "--no-deps", "--no-build-isolation"]
    command = [sys.executable, "-m", "pip", "install", *flags, "--target", str(target), str(source)]
    subprocess.run(command, timeout=120, check=True)
    return target


def evaluation(folder: Path) -> dict[str, dict[str, list[float]]]:
    """The one `eval.json` under `folder`."""
    (path,) = folder.rglob("eval.json")
    read: dict[str, dict[str, list[float]]] = json.loads(path.read_text(encoding="utf-8"))
    return read


def test_every_example_is_tested(root: Path) -> None:
    assert {path.name for path in (root / "examples").iterdir() if path.is_dir()} == set(EXAMPLES)


@pytest.mark.parametrize("copied", EXAMPLES, indirect=True)
def test_the_quick_commands_of_an_example_run(copied: Path) -> None:
    quick = [block for block in blocks((copied / "README.md").read_text()) if not block.mark]
    assert quick
    for block in quick:
        run_block(block, copied)


@pytest.mark.parametrize("copied", EXAMPLES, indirect=True)
def test_an_example_compiles_from_another_folder(copied: Path, tiloilc: Run) -> None:
    (spec,) = copied.glob("*.yaml")
    tiloilc("compile", spec.relative_to(copied.parent), "-o", "out", cwd=copied.parent)
    plan = json.loads((copied.parent / "out" / "plan.json").read_text(encoding="utf-8"))
    assert plan["name"] == spec.stem


@pytest.mark.parametrize("copied", ["own_environment"], indirect=True)
def test_the_own_environment_is_an_ordinary_one(copied: Path) -> None:
    program = (
        "import gymnasium, courier\n"
        "from gymnasium.utils.env_checker import check_env\n"
        "check_env(gymnasium.make('Courier-v0').unwrapped)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=copied, timeout=120, check=False)
    assert done.returncode == 0


@pytest.mark.parametrize("copied", ["own_demonstrations"], indirect=True)
def test_the_demonstrations_in_the_tree_are_what_the_script_writes(copied: Path) -> None:
    before = (copied / "routes.npz").read_bytes()
    subprocess.run([sys.executable, "make_demonstrations.py"], cwd=copied, timeout=60, check=True)
    with np.load(copied / "routes.npz", allow_pickle=False) as made:
        now = {name: made[name] for name in made.files}
    (copied / "routes.npz").write_bytes(before)
    with np.load(copied / "routes.npz", allow_pickle=False) as kept:
        assert kept.files == list(now)
        for name in kept.files:
            np.testing.assert_allclose(kept[name], now[name], atol=1e-6)


@pytest.mark.parametrize("copied", ["own_demonstrations"], indirect=True)
def test_a_demonstration_through_the_blue_disc_is_reported(copied: Path, tiloilc: Run) -> None:
    straight = np.linspace((-1.0, -1.0), (1.0, 1.0), 11, dtype=np.float32)
    np.savez(copied / "routes.npz", **{f"observations_{i}": straight for i in range(3)})
    told = tiloilc("lint", "settle.yaml", cwd=copied, status=0)
    assert "DEMO503" in told.stdout + told.stderr


@pytest.mark.slow
@pytest.mark.parametrize("copied", ["own_environment"], indirect=True)
def test_the_courier_learns_to_deliver(copied: Path, tiloilc: Run) -> None:
    tiloilc("run", "courier.yaml", cwd=copied)
    greedy = evaluation(copied)["greedy"]
    assert min(greedy["accepting_visits"]) >= 3
    assert max(greedy["violation_rate"]) == 0
    tiloilc("verify", "runs/courier/0001", "--at-least", "1", cwd=copied)


@pytest.mark.slow
@pytest.mark.parametrize("copied", ["own_demonstrations"], indirect=True)
def test_the_point_learns_to_settle(copied: Path, tiloilc: Run) -> None:
    tiloilc("run", "settle.yaml", cwd=copied)
    greedy = evaluation(copied)["greedy"]
    assert np.mean(greedy["accepting_visits"]) >= 40
    assert np.mean(greedy["violation_rate"]) <= 0.1


@pytest.mark.parametrize("copied", ["third_party"], indirect=True)
def test_the_car_trains_on_recorded_demonstrations(copied: Path, tiloilc: Run) -> None:
    before = (copied / "swing.npz").read_bytes()
    how = ("--expert", "drive.py:drive", "--noise", "0.5", "-o", "swing.npz")
    tiloilc("demos", "record", "swing.yaml", *how, cwd=copied)
    assert (copied / "swing.npz").read_bytes() == before
    few = ("--steps=400", "--seeds=1", "--set=learning_starts=200", "--set=warm_start=none", "-q")
    tiloilc("compile", "swing.yaml", cwd=copied)
    tiloilc("train", "build/swing", *few, cwd=copied)
    tiloilc("eval", "runs/swing/0001", "--episodes", "2", cwd=copied)
    tiloilc("report", "runs/swing/0001", cwd=copied)
    assert len(evaluation(copied)["greedy"]["accepting_visits"]) == 1
    (page,) = copied.rglob("report.html")
    assert "F (left &amp; X F flag)" in page.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("copied", ["third_party"], indirect=True)
def test_the_car_learns_to_swing_and_to_reach_the_flag(copied: Path, tiloilc: Run) -> None:
    tiloilc("lint", "swing.yaml", cwd=copied)
    tiloilc("run", "swing.yaml", cwd=copied)
    judged = evaluation(copied)
    assert min(judged["greedy"]["success"]) == 1
    assert np.mean(judged["greedy"]["success"]) >= np.mean(judged["cloning"]["success"])
    tiloilc("eval", "runs/swing/0001", "--video", cwd=copied)
    assert (copied / "runs/swing/0001/video.gif").read_bytes().startswith(b"GIF89a")


@pytest.mark.slow
@pytest.mark.parametrize("copied", ["imported_automaton"], indirect=True)
def test_the_patrol_makes_its_rounds(copied: Path, tiloilc: Run) -> None:
    tiloilc("run", "patrol.yaml", cwd=copied)
    greedy = evaluation(copied)["greedy"]
    assert min(greedy["accepting_visits"]) >= 1
    assert max(greedy["violation_rate"]) == 0


@pytest.mark.parametrize("copied", ["exported_policy"], indirect=True)
def test_both_programs_drive_alike(copied: Path, tiloilc: Run) -> None:
    tiloilc("run", "corridor.yaml", "-q", cwd=copied)
    tiloilc("export", "runs/corridor/0001", "-o", "corridor", "-q", cwd=copied)
    said = [
        subprocess.run(
            [sys.executable, *program], cwd=copied, timeout=60, check=True, capture_output=True
        ).stdout.decode()
        for program in (("drive.py", "runs/corridor/0001"), ("drive_onnx.py", "corridor"))
    ]
    assert said == ["accepting at 11 of 17 steps\n"] * 2


@pytest.mark.parametrize("copied", ["imported_automaton"], indirect=True)
def test_a_plan_is_stale_when_its_automaton_was_changed(copied: Path, tiloilc: Run) -> None:
    tiloilc("compile", "patrol.yaml", cwd=copied)
    with (copied / "patrol.hoa").open("a", encoding="utf-8") as file:
        file.write("/* changed */\n")
    told = tiloilc("train", "build/patrol", cwd=copied, status=1)
    assert "error[PLAN401]: `patrol.hoa` changed after the plan was compiled" in told.stderr
    assert not (copied / "runs").exists()


@pytest.mark.parametrize("copied", ["own_algorithm"], indirect=True)
def test_an_algorithm_that_is_not_installed_is_reported(
    copied: Path, tiloilc: Run, tmp_path: Path
) -> None:
    shutil.rmtree(tmp_path / "installed")
    told = tiloilc("lint", "stay.yaml", cwd=copied, status=1)
    assert "JOB610" in told.stdout + told.stderr


@pytest.mark.slow
@pytest.mark.parametrize("copied", ["own_algorithm"], indirect=True)
def test_the_own_algorithm_learns_to_stay(copied: Path, tiloilc: Run) -> None:
    tiloilc("run", "stay.yaml", cwd=copied)
    assert np.mean(evaluation(copied)["greedy"]["accepting_visits"]) >= 46
    (events,) = copied.rglob("events.jsonl")
    assert '"critic"' in events.read_text(encoding="utf-8")
    assert '"discriminator"' not in events.read_text(encoding="utf-8")
