"""One job at work: its folder, its process, and what came of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from tiloilc.diag import CompileError
from tiloilc.evaluate import Record, read

RECORDS, RUNS, LOG = "records.jsonl.gz", "runs", "log.txt"
"""What a job leaves in its folder: its records when it is done, its run, what it said."""

TAIL = 12
"""Lines of a failed job's log that are told."""

PAUSE = 0.1
"""Seconds between two looks at a process."""

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Work:
    """What a worker must know of a job. `folder` and `build` are absolute paths.

    `arguments` are the settings for `tiloilc run`.
    """

    id: str
    folder: str
    build: str
    arguments: tuple[str, ...]
    cost: int

    def lost(self, problem: str, tail: tuple[str, ...] = ()) -> Outcome:
        """That nothing came of it, and why."""
        return Outcome(self.id, (), problem, tail, 0.0)


@dataclass(frozen=True)
class Outcome:
    """What came of a job: its records, or why there are none, and the end of its log."""

    id: str
    records: tuple[Record, ...]
    problem: str
    tail: tuple[str, ...]
    seconds: float


def arguments(changes: Mapping[str, object]) -> tuple[str, ...]:
    """Changed settings as options of `tiloilc run`."""
    given = []
    for name, value in changes.items():
        if name in ("steps", "seeds"):
            given += [f"--{name}", str(value)]
        else:
            given += ["--set", f"{name}={value if isinstance(value, str) else json.dumps(value)}"]
    return tuple(given)


class Process:
    """The program of a job, which runs from now on."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self.folder = Path(work.folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.began = time.monotonic()
        with open(self.folder / LOG, "ab") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "tiloilc.sweep.child", work.folder,
                 "run", work.build, *work.arguments,
                 "--record", str(self.folder / RECORDS), "--runs", str(self.folder / RUNS)],
                cwd=work.folder,
                env=environment(),
                stdin=subprocess.PIPE,
                stdout=log,
                stderr=log,
                start_new_session=True,  # Ctrl-C is for the sweep, which then tells its jobs
            )  # fmt: skip

    def outcome(self) -> Outcome | None:
        """What came of it; None as long as it runs."""
        status = self._process.poll()
        if status is None:
            return None
        self.interrupt()
        seconds = time.monotonic() - self.began
        records, problem = outcome_of(self.folder, status)
        tail = tuple(tail_of(self.folder / LOG)) if problem else ()
        return Outcome(self.work.id, records, problem, tail, seconds)

    def interrupt(self) -> None:
        """Have it write a checkpoint and end."""
        assert self._process.stdin is not None
        self._process.stdin.close()

    def end(self) -> None:
        """Interrupt it and wait until it has ended; if that is interrupted, kill it."""
        self.interrupt()
        try:
            self._process.wait()
        except BaseException:
            self._process.kill()
            self._process.wait()
            raise


def begin(work: Work) -> Process | Outcome:
    """The job's program, running; or why it could not begin."""
    try:
        return Process(work)
    except OSError as error:
        return work.lost(str(error))


def do(work: Work, watch: Callable[[Process], None] = lambda process: None) -> Outcome:
    """Do a job to its end, on whichever machine this is; what goes wrong is in the outcome.

    `watch` looks at the process now and then. If it raises, or this is interrupted, so is the job,
    which then writes a checkpoint.
    """
    process = begin(work)
    if isinstance(process, Outcome):
        return process
    try:
        while (outcome := process.outcome()) is None:
            watch(process)
            time.sleep(PAUSE)
    finally:
        process.end()
    return outcome


def outcome_of(folder: Path, status: int) -> tuple[tuple[Record, ...], str]:
    """The records that a job left, or what is wrong."""
    if status != 0:
        return (), f"killed by signal {-status}" if status < 0 else f"exit status {status}"
    try:
        return left(folder), ""
    except CompileError as error:
        return (), str(error)


def left(folder: Path) -> tuple[Record, ...]:
    """The records of a finished job in its folder. Raises CompileError RUN701."""
    return tuple(read(folder / RECORDS))


def tail_of(log: Path) -> list[str]:
    """The last lines of a log."""
    try:
        text = log.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    return text.splitlines()[-TAIL:]


def environment() -> dict[str, str]:
    """This process's environment for a child in another folder: one thread, absolute paths."""
    paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    places = os.pathsep.join(str(Path(path).resolve()) for path in paths if path)
    return {**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONPATH": places}
