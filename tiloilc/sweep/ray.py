"""The engine of many machines: jobs are tasks of a Ray cluster, records come back as values."""

from __future__ import annotations

import dataclasses
import logging
import os
import tempfile
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tiloilc.diag import CompileError
from tiloilc.sweep.engine import Event, unusable
from tiloilc.sweep.parcel import Parcel, pack, unpack
from tiloilc.sweep.work import Outcome, Process, Work, do

OF_TASKS = ("max_retries", "memory", "num_cpus", "num_gpus", "resources")
"""Options of each job; the others are those of `ray.init`, as `address`."""

RETRIES = 20
"""How often a job begins anew because its machine was lost; it goes on where that is seen."""

QUIETLY: Mapping[str, object] = {
    "logging_level": logging.ERROR,
    "log_to_driver": False,
    "include_dashboard": False,
}
"""Options of `ray.init`, unless told otherwise."""

GRACE = 60.0
"""Seconds that cancelled jobs have for a last checkpoint."""


@dataclass(frozen=True)
class Ray:
    """Tasks of the cluster at RAY_ADDRESS, or at `address`, or on this machine if there is none."""

    options: Mapping[str, object] = field(default_factory=dict)

    def results(self, works: Sequence[Work]) -> Generator[Event, None, None]:
        """Do the jobs wherever there is a processor; those of a lost machine on another.

        A job is told of when it has ended. Raises CompileError RUN715 if there is no cluster, or
        none that takes the options.
        """
        ray = require()
        begun_here = not ray.is_initialized()
        tasks = {"num_cpus": 1, "max_retries": RETRIES, **self._options(tasks=True)}
        try:
            remote = ray.remote(do_task).options(**tasks)
            if begun_here:
                ray.init(**{**QUIETLY, **self._options(tasks=False)})
        except Exception as error:
            raise unusable("ray", error) from None
        pending: dict[Any, Work] = {}
        try:
            parcels = {build: ray.put(pack(Path(build))) for build in {w.build for w in works}}
            pending = {remote.remote(work, parcels[work.build]): work for work in works}
            while pending:
                ready, _ = ray.wait(list(pending), timeout=0.5)
                for reference in ready:
                    yield _outcome(ray, reference, pending.pop(reference))
                yield None
        finally:
            for reference in pending:
                ray.cancel(reference)
            if pending:
                ray.wait(list(pending), num_returns=len(pending), timeout=GRACE)
            if begun_here:
                ray.shutdown()

    def _options(self, tasks: bool) -> dict[str, object]:
        return {k: v for k, v in self.options.items() if (k in OF_TASKS) == tasks}


def do_task(work: Work, parcel: Parcel) -> Outcome:
    """What a node does: the job, with the build and in the folder that this machine has.

    A worker can outlive its node's raylet, which is its parent. Then the job is done elsewhere, so
    it is ended here, and the worker with it.
    """
    raylet = os.getppid()

    def watch(process: Process) -> None:
        if os.getppid() != raylet:
            process.end()
            os._exit(1)

    try:
        here = moved(work, parcel)
    except (OSError, CompileError) as error:
        return work.lost(str(error))
    return do(here, watch)


def moved(work: Work, parcel: Parcel) -> Work:
    """The job as this machine can do it: in its own folder if that can be made here, too."""
    folder = Path(work.folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        folder = Path(tempfile.gettempdir()) / "tiloilc-sweep" / work.id
    build = unpack(parcel, Path(work.build), folder)
    return dataclasses.replace(work, folder=str(folder), build=str(build))


def require() -> Any:
    """The library. Raises CompileError RUN715 if it is not installed."""
    try:
        import ray
    except ImportError:
        raise unusable("ray", "Ray is not installed", "pip install 'tiloilc[ray]'") from None
    return ray


def _outcome(ray: Any, reference: Any, work: Work) -> Outcome:
    try:
        outcome = ray.get(reference)
    except ray.exceptions.RayError as error:
        lines = [line for line in str(error).splitlines() if line.strip()]
        return work.lost(lines[-1] if lines else type(error).__name__)
    assert isinstance(outcome, Outcome)
    return outcome
