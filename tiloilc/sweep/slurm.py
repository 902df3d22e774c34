"""The engine of a Slurm cluster, through submitit."""

from __future__ import annotations

import time
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tiloilc.sweep.engine import Event, Started, unusable
from tiloilc.sweep.work import TAIL, Outcome, Process, Work, do

DEFAULTS: Mapping[str, object] = {"name": "tiloilc", "cpus_per_task": 1, "timeout_min": 240}
"""submitit's own limit is five minutes. A job that reaches the limit is submitted again."""

TIMEOUTS = 100
"""How often a job may reach the limit."""

PAUSE, GRACE = 0.5, 60.0
"""Seconds between two looks at all jobs; seconds a job has for a checkpoint at its limit."""


@dataclass(frozen=True)
class Slurm:
    """Jobs of a Slurm cluster, whose nodes see `folder` under the same path.

    `options` are parameters of submitit's executor; `cluster` is slurm, local or debug.
    """

    folder: Path
    options: Mapping[str, object] = field(default_factory=dict)

    def results(self, works: Sequence[Work]) -> Generator[Event, None, None]:
        """Submit the jobs as one array. When it is closed, those that have not ended are cancelled.

        Raises CompileError RUN715 if the cluster cannot be used.
        """
        pending: dict[Any, Work] = {}
        try:
            pending = self._submit(works)
            for work in works:
                yield Started(work.id)
            while pending:
                for job in [job for job in pending if job.done()]:
                    yield _outcome(job, pending.pop(job))
                yield None
                time.sleep(PAUSE)
        finally:
            for job in pending:
                job.cancel(check=False)

    def _submit(self, works: Sequence[Work]) -> dict[Any, Work]:
        submitit = require()
        parameters = {**DEFAULTS, **self.options}
        cluster = parameters.pop("cluster", "slurm")
        try:
            executor = submitit.AutoExecutor(
                folder=self.folder.resolve() / "slurm",
                cluster=cluster,
                slurm_max_num_timeout=TIMEOUTS,
            )
            executor.update_parameters(**parameters)
            with executor.batch():
                jobs = [executor.submit(Task(), work) for work in works]
        except Exception as error:
            raise unusable("slurm", error) from None
        return dict(zip(jobs, works, strict=True))


class Task:
    """What submitit calls on a node; at the limit of time it has the job submitted again."""

    def __init__(self) -> None:
        self.process: Process | None = None

    def __call__(self, work: Work) -> Outcome:
        """Do the job."""
        return do(work, self._hold)

    def _hold(self, process: Process) -> None:
        self.process = process

    def checkpoint(self, work: Work) -> Any:
        """Let the job write a checkpoint, from which the next submission goes on."""
        from submitit.helpers import DelayedSubmission

        if self.process is not None:
            self.process.interrupt()
            end = time.monotonic() + GRACE
            while self.process.outcome() is None and time.monotonic() < end:
                time.sleep(PAUSE)
        return DelayedSubmission(Task(), work)


def require() -> Any:
    """The library. Raises CompileError RUN715 if it is not installed."""
    try:
        import submitit
    except ImportError:
        help = "pip install 'tiloilc[slurm]'"
        raise unusable("slurm", "submitit is not installed", help) from None
    return submitit


def _outcome(job: Any, work: Work) -> Outcome:
    """What came of a job of the cluster, or how the cluster lost it."""
    try:
        outcome = job.result()
    except Exception as error:
        lines = [line for line in str(error).splitlines() if line.strip()]
        problem = lines[0] if lines else type(error).__name__
        return work.lost(f"job {job.job_id}: {problem}", tuple(lines[-TAIL:]))
    assert isinstance(outcome, Outcome)
    return outcome
