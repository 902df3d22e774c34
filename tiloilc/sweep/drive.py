"""The sweep itself: what is left to do is done by an engine and recorded as it comes in."""

from __future__ import annotations

import dataclasses
import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from tiloilc.driver import plan_file, write_build
from tiloilc.evaluate import Record, append
from tiloilc.plan import digest
from tiloilc.sweep.engine import Engine, Event
from tiloilc.sweep.experiments import Experiment, Job
from tiloilc.sweep.work import RECORDS, Outcome, Work, arguments, left

JOBS, BUILDS = "jobs", "builds"


@dataclass(frozen=True)
class Sweep:
    """Experiments with the jobs that are left of them, and the folder in which they are done."""

    experiments: Sequence[Experiment]
    jobs: Sequence[Job]
    folder: Path

    def job_folder(self, job: Job) -> Path:
        """Where a job is done."""
        return self.folder / JOBS / job.id

    def command(self, job: Job) -> list[str]:
        """The command that does a job alone, in a run folder of its own."""
        one = self.experiments[job.number]
        record = ["--record", one.records.as_posix()]
        return [
            "tiloilc",
            "run",
            one.spec.as_posix(),
            *arguments({**one.shown, **job.changes}),
            *record,
        ]


def collect(sweep: Sweep) -> list[Job]:
    """Record what jobs left that had ended when the sweep before was killed; the jobs left."""
    remaining = []
    for job in sweep.jobs:
        folder = sweep.job_folder(job)
        if not (folder / RECORDS).is_file():
            remaining.append(job)
            continue
        problem = _record(sweep, job, left(folder))
        assert not problem, problem
    return remaining


def carry_out(
    sweep: Sweep, engine: Engine, watch: Callable[[Event], None]
) -> Mapping[str, Outcome]:
    """Do all jobs; the outcomes of those that failed, by the jobs' ids."""
    builds = _write_builds(sweep)
    works = [
        Work(
            job.id,
            str(sweep.job_folder(job).resolve()),
            str(builds[job.number].resolve()),
            arguments(job.changes),
            job.cost,
        )
        for job in sweep.jobs
    ]
    jobs = {job.id: job for job in sweep.jobs}
    failed = {}
    with closing(engine.results(works)) as events:
        for event in events:
            if isinstance(event, Outcome):
                problem = event.problem or _record(sweep, jobs[event.id], event.records)
                if problem:
                    event = dataclasses.replace(event, records=(), problem=problem)
                    failed[event.id] = event
            watch(event)
    return failed


def _record(sweep: Sweep, job: Job, records: Sequence[Record]) -> str:
    """Add a job's records to their file; else what is wrong with them."""
    one = sweep.experiments[job.number]
    wanted = digest(one.plan_of(job.seeds))
    if any(record.fields.get("plan_digest") != wanted for record in records):
        return "its records are of another plan"
    if sorted(str(record.fields.get("seed")) for record in records) != sorted(map(str, job.seeds)):
        return "its records are not of its seeds"
    append(one.records, records)
    return ""


def _write_builds(sweep: Sweep) -> dict[int, Path]:
    """The compiled task of each experiment that has jobs, so that no job compiles it again."""
    builds: dict[int, Path] = {}
    for number in sorted({job.number for job in sweep.jobs}):
        task = sweep.experiments[number].task
        key = hashlib.sha256(f"{task.plan.root}{os.sep}{digest(task.plan)}".encode()).hexdigest()
        builds[number] = sweep.folder / BUILDS / f"{task.plan.name}-{key[:12]}"
        if not plan_file(builds[number]).is_file():  # the plan is written last
            write_build(task, builds[number])
    return builds
