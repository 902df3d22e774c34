"""The engine of a Slurm cluster, with submitit's executors that need none."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cli.running import Run, runner
from tests.conftest import ROOT
from tests.sweep.made import experiments, task
from tiloilc.diag import CompileError
from tiloilc.evaluate import read
from tiloilc.sweep import Outcome, Slurm, Sweep, carry_out, jobs_of
from tiloilc.sweep.slurm import Task
from tiloilc.sweep.work import Work


@pytest.fixture(autouse=True)
def closed_logs(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """submitit's debug executor leaves its log files open."""
    made: list[logging.FileHandler] = []

    class Kept(logging.FileHandler):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            made.append(self)

    monkeypatch.setattr(logging, "FileHandler", Kept)
    yield
    for handler in made:
        handler.close()


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.mark.slow
def test_a_sweep_by_the_debug_executor_records_every_seed_once(workdir: Path, run: Run) -> None:
    path = task(workdir)
    options = ("--engine", "slurm", "--engine-set", "cluster=debug", "--seeds-per-job", 1)
    status, out, err = run("sweep", path.name, *options, "--algorithms", "tiloil")
    assert status == 0, err
    records = read(Path("results/corridor.jsonl.gz"))
    assert [record.fields["seed"] for record in records] == [0, 1]
    assert out.splitlines()[1].split()[3] == "2"
    again = run("sweep", path.name, *options, "--algorithms", "tiloil", "-q")
    assert again == (0, out, "")


@pytest.mark.slow
def test_a_job_that_fails_on_the_cluster_is_told(tmp_path: Path) -> None:
    found = experiments(task(tmp_path), seeds=1, records=str(tmp_path / "results"))
    sweep = Sweep(found, jobs_of(found, [()]), tmp_path / "runs")
    (job,) = sweep.jobs
    sweep.job_folder(job).parent.mkdir(parents=True)
    sweep.job_folder(job).write_text("in the way")
    failed = carry_out(sweep, Slurm(tmp_path, {"cluster": "debug"}), lambda event: None)
    assert list(failed) == [job.id]
    assert "File exists" in failed[job.id].problem


@pytest.mark.slow
def test_a_sweep_by_processes_of_submitit_records_every_seed(tmp_path: Path) -> None:
    """Its local executor pickles jobs and starts them with its own program, as on a cluster."""
    task(tmp_path)
    command = ["sweep", "corridor.yaml", "--engine", "slurm", "--engine-set", "cluster=local"]
    done = subprocess.run(
        [sys.executable, "-m", "tiloilc", *command],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert len(read(tmp_path / "results/corridor.jsonl.gz")) == 2


@pytest.mark.parametrize(
    ("options", "words"),
    [({"cluster": "nowhere"}, "nowhere"), ({"cluster": "debug", "no_such": 1}, "no_such")],
)
def test_an_option_that_the_cluster_has_not_is_a_finding(
    tmp_path: Path, options: dict[str, object], words: str
) -> None:
    work = Work("job", str(tmp_path / "job"), str(tmp_path), (), 1)
    with pytest.raises(CompileError, match=r"RUN715.*" + words):
        list(Slurm(tmp_path, options).results([work]))


class Slow:
    """A process that ends a moment after it was interrupted."""

    def __init__(self) -> None:
        self.interrupted = 0.0

    def interrupt(self) -> None:
        self.interrupted = time.monotonic()

    def outcome(self) -> Outcome | None:
        over = self.interrupted and time.monotonic() > self.interrupted + 0.2
        return Outcome("job", (), "exit status 130", (), 0.0) if over else None


def test_at_its_limit_of_time_a_job_writes_a_checkpoint_and_is_submitted_again() -> None:
    work, process = Work("job", "folder", "build", (), 1), Slow()
    first = Task()
    first.process = process  # type: ignore[assignment]
    again = first.checkpoint(work)
    assert process.outcome() is not None
    assert isinstance(again.function, Task)
    assert again.function.process is None
    assert again.args == (work,)
