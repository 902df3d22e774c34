"""`tiloilc sweep` from the command line: what it lists, prints, refuses and goes on with."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.cli.running import Run, runner
from tests.sweep.made import experiments, records_of, task
from tiloilc.evaluate import Record, append, read


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


def recorded(path: Path, made: range, **options: object) -> None:
    """Have the seeds of an experiment recorded in results/."""
    (one,) = experiments(path, **options)
    append(one.records, records_of(one, made))


def test_a_dry_run_lists_the_jobs_and_what_is_recorded(workdir: Path, run: Run) -> None:
    recorded(task(workdir), range(1), settings={"beta": 0.25}, seeds=2)
    changes = ("--set", "beta=1/4", "--seeds", 2, "--algorithms", "tiloil,gail")
    status, out, err = run("sweep", "corridor.yaml", *changes, "--dry-run")
    assert status == 0
    assert out.splitlines() == [
        "to do    corridor  gail beta=0.25  seeds 0–1  400 steps",
        "to do    corridor  tiloil beta=0.25  seed 1  400 steps",
        "recorded corridor  tiloil beta=0.25  1 of 2 seeds",
    ]
    assert "1 of 4 seeds are recorded; 2 jobs to do" in err
    assert not Path("runs").exists()


def test_what_is_recorded_is_not_done_again(workdir: Path, run: Run) -> None:
    recorded(task(workdir), range(2))
    status, out, _ = run("sweep", "corridor.yaml", "-q")
    assert status == 0
    assert out.splitlines()[1].split()[:4] == ["corridor", "tiloil", "400", "2"]
    assert not Path("runs").exists()


def test_records_from_elsewhere_are_taken_over_and_count(workdir: Path, run: Run) -> None:
    path = task(workdir)
    (one,) = experiments(path, records="away/{name}.jsonl.gz")
    append(Path("away/corridor.jsonl.gz"), records_of(one, range(1)))
    append(Path("more.jsonl"), records_of(one, range(2)))
    assert run("sweep", "--merge", "away", "--records", "kept", "-q") == (0, "", "")
    assert len(read(Path("kept/corridor.jsonl.gz"))) == 1
    status, out, err = run("sweep", path, "--merge", "away", "--merge", "more.jsonl")
    assert status == 0
    assert "corridor.jsonl.gz has 3 records" in err  # seed 0 by two plans: alone, and with seed 1
    assert out.splitlines()[1].split()[3] == "2"  # and counted once


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "name task files"),
        (["corridor.yaml", "--set", "bta=1"], "no setting `bta`"),
        (["corridor.yaml", "--records", "x/{nam}.jsonl.gz"], "--records may have {name} and"),
        (["corridor.yaml", "--records", "x/{name"], "--records may have {name} and"),
        (["corridor.yaml", "--records", "y/{name}.txt"], "--records must end in .jsonl or"),
        (["corridor.yaml", "--set", "seeds=1"], "--seeds"),
        (["corridor.yaml", "--set", "steps=1", "--steps", "9"], "`steps` is given twice"),
        (
            ["corridor.yaml", "--set", "algorithm=gail", "--algorithms", "lcer"],
            "`algorithm` is given twice",
        ),
        (["corridor.yaml", "--merge", "no/where", "--dry-run"], "there is no `no/where`"),
        (["corridor.yaml", "--records", "corridor.yaml"], "corridor.yaml"),
        (
            ["corridor.yaml", "--set", "demonstrations.cont=1"],
            "did you mean `demonstrations.count`",
        ),
        (["corridor.yaml", "--set", "demonstrations.count=-1"], "at least 0"),
        (["corridor.yaml", "--set", "beta=-1"], "at least 0"),
        (["corridor.yaml", "--seeds", "1001"], "Invalid value for '--seeds'"),
        (["corridor.yaml", "--first-seed", "99999999999"], "Invalid value for '--first-seed'"),
        (["corridor.yaml", "--engine", "rai"], "local, ray, slurm"),
        (["corridor.yaml", "--same", "x"], "plan, commit, spec"),
        (["corridor.yaml", "--engine-set", "x=1"], "Ray and Slurm"),
        (["none.yaml"], "none.yaml"),
    ],
)
def test_a_wrong_option_is_a_usage_error(
    workdir: Path, run: Run, arguments: list[str], words: str
) -> None:
    task(workdir)
    status, out, err = run("sweep", *arguments)
    assert (status, out) == (2, "")
    assert words in err


def test_the_last_of_the_seeds_of_the_command_line_must_be_one(workdir: Path, run: Run) -> None:
    task(workdir)
    first = ("--first-seed", 2**31 - 5)
    assert run("sweep", "corridor.yaml", *first, "--seeds", 5, "--dry-run")[0] == 0
    status, out, err = run("sweep", "corridor.yaml", *first, "--seeds", 6, "--dry-run")
    assert (status, out) == (1, "")
    assert (
        "error[JOB604]: setting `first_seed`: the others count up to 2,147,483,648\n"
        "  = help: no seed goes beyond 2,147,483,647\n"
    ) in err


def test_a_mistake_in_the_last_is_told_before_the_first_begins(workdir: Path, run: Run) -> None:
    task(workdir, "a")
    task(workdir, "b", formula='formula: "F q"')
    status, out, err = run("sweep", "a.yaml", "b.yaml", "--algorithms", "tiloil,gibtsnicht")
    assert (status, out) == (1, "")
    assert "LTL203" in err
    assert "JOB610" in err
    assert not Path("runs").exists()


IGNORE = "import os, signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN); "
GO_ON = "os.execv(sys.executable, [sys.executable, *sys.argv[1:]])"


def started(folder: Path, *arguments: str, before: tuple[str, ...] = ()) -> subprocess.Popen[str]:
    """A sweep as a program in a process group of its own."""
    return subprocess.Popen(
        [sys.executable, *before, "-m", "tiloilc", "sweep", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(Path.cwd()), *sys.path])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def until(there: str, folder: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a file of this pattern is there, with something in it."""
    while not any(path.stat().st_size for path in folder.glob(there)):
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


@pytest.mark.slow
def test_a_failed_job_does_not_stop_the_others_and_is_told_with_its_command(
    workdir: Path, run: Run
) -> None:
    task(workdir, "good")
    bad = task(workdir, "bad", propositions='propositions:\n  w: {python: "labels.py:w"}')
    Path("labels.py").write_text(
        "import os\n\n\ndef w(observations):\n"
        "    if os.environ.get('OMP_NUM_THREADS') == '1' and 'sweep' in os.getcwd():\n"
        "        raise RuntimeError('out of order')\n"
        "    return observations[:, 0] > 99\n"
    )
    bad.write_text(bad.read_text().replace("& G !z", "& G !z & G !w"))
    status, out, err = run("sweep", "bad.yaml", "good.yaml", "--workers", 1)
    assert status == 1
    rows = {line.split()[0]: line.split()[3] for line in out.splitlines()[1:]}
    assert rows == {"bad": "0", "good": "2"}
    assert "out of order" in err
    assert "tiloilc run bad.yaml --seeds 2 --set first_seed=0 --record" in err
    assert "1 of 2 jobs failed" in err


LONG = (
    *("corridor.yaml", "--algorithms", "tiloil,gail", "--seeds-per-job", "1"),
    *("--steps", "4000", "--set", "learning_starts=2000"),
)


def same_part(record: Record) -> dict[str, object]:
    """All of a record but how long it took, which no two runs have in common."""
    return {key: value for key, value in record.fields.items() if key != "wall_seconds"}


@pytest.mark.slow
def test_a_sweep_over_demonstrations_makes_each_once(workdir: Path, run: Run) -> None:
    task(workdir)
    Path("counts.yaml").write_text(
        "specs: [corridor.yaml]\ngrid: {demonstrations.count: [1, 3]}\nseeds: 1\n"
    )
    status, out, _ = run("sweep", "counts.yaml", "--steps", 60)
    assert status == 0
    words = ["demonstrations.count=1", "demonstrations.count=3"]
    assert [line.split()[2] for line in out.splitlines()[1:]] == words
    assert len(list(Path("runs/sweep/builds").iterdir())) == 2
    assert len(list(Path("runs/sweep/jobs").iterdir())) == 2
    records = [record.fields for record in read(Path("results/corridor.jsonl.gz"))]
    named = [fields["demonstrations"] for fields in records]
    counts = {one["count"] for one in named if isinstance(one, dict)}
    assert counts == {1, 3}
    assert len({str(fields["plan_digest"]) for fields in records}) == len(records) == 2
    status, again, err = run("sweep", "counts.yaml", "--steps", 60)
    assert (status, again) == (0, out)
    assert "2 of 2 seeds are recorded; 0 jobs to do" in err
    option = ("--set", "demonstrations.count=3", "--seeds", 1, "--steps", 60)
    assert run("sweep", "corridor.yaml", *option, "--dry-run")[1].startswith("recorded ")
    assert run("sweep", "corridor.yaml", *option[2:], "--dry-run")[1].startswith("to do ")


@pytest.mark.slow
def test_a_sweep_killed_at_any_moment_ends_like_one_that_never_was(tmp_path: Path) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    for folder in (whole, killed):
        folder.mkdir()
        task(folder)
    process = started(whole, *LONG)
    table, _ = process.communicate(timeout=1800)
    assert process.returncode == 0
    process = started(killed, *LONG)
    until("runs/sweep/jobs/*/runs/*/*/checkpoints/*.json", killed, process)
    jobs = children(process.pid)
    assert jobs
    os.killpg(process.pid, signal.SIGKILL)
    for job in jobs:  # the first time all dies at once
        os.kill(job, signal.SIGKILL)
    process.communicate()
    process = started(killed, *LONG)
    until("results/*.gz", killed, process)
    os.killpg(process.pid, signal.SIGKILL)  # the second time its jobs are left to find out
    process.communicate()
    process = started(killed, *LONG, "--quiet")
    again, said = process.communicate(timeout=1800)
    assert (process.returncode, said) == (0, "")
    assert again == table
    records = [read(folder / "results/corridor.jsonl.gz") for folder in (whole, killed)]
    assert [same_part(r) for r in records[0]] == [same_part(r) for r in records[1]]
    assert len(records[0]) == 4


@pytest.mark.slow
def test_jobs_end_with_their_sweep_whatever_signals_are_blocked(tmp_path: Path) -> None:
    """Ray's workers block SIGINT, a shell's background jobs ignore it; both are inherited."""
    task(tmp_path)
    block = "signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}); "
    script = IGNORE + block + GO_ON
    options = ("corridor.yaml", "--steps", "1_000_000", "--set", "checkpoint_every=1_000_000")
    process = started(tmp_path, *options, before=("-c", script))
    until("runs/sweep/jobs/*/runs/*/*/events.jsonl", tmp_path, process)
    (job,) = children(process.pid)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    until_gone(job)
    assert list(tmp_path.glob("runs/sweep/jobs/*/runs/*/*/checkpoints/*.json"))


def until_gone(pid: int) -> None:
    """Wait until there is no such process."""
    with contextlib.suppress(ProcessLookupError):
        while True:
            os.kill(pid, 0)
            time.sleep(0.05)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["local", "ray"])
def test_an_interrupted_sweep_lets_its_jobs_write_checkpoints(tmp_path: Path, engine: str) -> None:
    task(tmp_path)
    options = ("--steps", "1_000_000", "--set", "checkpoint_every=1_000_000", "--seeds", "1")
    ignoring = ("-c", IGNORE + GO_ON)  # as a shell's background jobs do
    process = started(tmp_path, "corridor.yaml", *options, "--engine", engine, before=ignoring)
    until("runs/sweep/jobs/*/runs/*/*/events.jsonl", tmp_path, process)
    os.kill(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=300)
    assert (process.returncode, out) == (130, "")
    assert "tiloilc sweep corridor.yaml" in err
    assert list(tmp_path.glob("runs/sweep/jobs/*/runs/*/*/checkpoints/*.json"))
    (lock,) = tmp_path.glob("runs/sweep/jobs/*/lock")
    with lock.open() as held:  # nobody works there any more
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)


def children(pid: int) -> list[int]:
    """The processes that a process has started."""
    ps = shutil.which("ps")
    assert ps is not None
    found = subprocess.run([ps, "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True)
    return [int(word) for word in found.stdout.split()]
