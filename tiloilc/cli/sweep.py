"""`tiloilc sweep`: many specs × algorithms × settings × seeds, each recorded once."""

from __future__ import annotations

import os
import shlex
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

import tiloilc
from tiloilc.cli.console import Quiet, fail, guests, report, say
from tiloilc.cli.settings import checked, settings_given
from tiloilc.cli.sweeping import SweepProgress, seeds_of
from tiloilc.cli.train import Set, Steps
from tiloilc.seeds import LAST_SEED, MOST_AGENTS

if TYPE_CHECKING:
    from tiloilc.sweep import Engine, Options, Outcome, Sweep

FOLDER = Path("runs/sweep")
ENGINES = ("local", "ray", "slurm")


def _engine(value: str) -> str:
    if value not in ENGINES:
        raise typer.BadParameter(f"one of {', '.join(ENGINES)}")
    return value


def _same(value: str) -> str:
    if value not in ("plan", "commit", "spec"):
        raise typer.BadParameter("one of plan, commit, spec")
    return value


def command(
    specs: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="SPEC", help="Task files, or sweep files.", exists=True, dir_okay=False
        ),
    ] = None,
    algorithms: Annotated[
        str | None, typer.Option("--algorithms", metavar="A,B,…", help="Each with every spec.")
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option("--seeds", min=1, max=MOST_AGENTS, help="Agents, instead of the specs'."),
    ] = None,
    first_seed: Annotated[
        int | None,
        typer.Option("--first-seed", min=0, max=LAST_SEED, help="The others count up."),
    ] = None,
    steps: Steps = None,
    changes: Set = None,
    seeds_per_job: Annotated[
        int | None, typer.Option("--seeds-per-job", min=1, help="Trained together [all].")
    ] = None,
    engine: Annotated[
        str, typer.Option(callback=_engine, help=f"One of {', '.join(ENGINES)}.")
    ] = "local",
    engine_options: Annotated[
        list[str] | None,
        typer.Option("--engine-set", metavar="NAME=VALUE", help="An option of Ray or Slurm."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=1, help="Jobs at a time, locally [cores].")
    ] = None,
    records: Annotated[
        str | None,
        typer.Option("--records", metavar="PLACE", help="A folder, or {name}.jsonl.gz [results]."),
    ] = None,
    folder: Annotated[Path, typer.Option("--runs", help="Where jobs have folders.")] = FOLDER,
    same: Annotated[
        str,
        typer.Option(
            callback=_same,
            metavar="plan|commit|spec",
            help="What a record shares with what is asked for, so that its seed is done.",
        ),
    ] = "plan",
    merge: Annotated[
        list[Path] | None,
        typer.Option("--merge", metavar="PATH", help="Take over records of a file or folder."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="List the jobs; do and write nothing.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Train many specs with many settings, and record every seed once.

    A job is one spec with one set of settings and all its seeds in one program. All specs and
    settings are checked before the first job begins. What is recorded is skipped; a sweep that was
    interrupted or killed goes on when it is started again. Prints a table of the records.

    A sweep file is YAML with `specs`, `algorithms`, `overrides`, `grid`, `seeds`, `first_seed`,
    `steps`, `seeds_per_job` and `records`; options take the place of what it says. Settings whose
    names begin with `demonstrations.` are laid over the task file's demonstrations.
    """
    import tiloilc.sweep as sweeps
    from tiloilc.diag import Severity
    from tiloilc.evaluate import prepare

    if not specs and not merge:
        raise fail("name task files or sweep files, or records to --merge")
    for path in merge or []:
        if not path.exists():
            raise fail(f"there is no `{path.as_posix()}` to --merge")
    options = _options(algorithms, steps, changes, seeds, first_seed, seeds_per_job, records)
    chosen = _chosen_engine(engine, workers, engine_options or [], folder)
    asked = sweeps.requests(specs or [], options)
    with guests():
        experiments, found = sweeps.check(asked)
    if not quiet:  # what is merely worth knowing of a task, `lint` tells
        report(finding for finding in found if finding.severity is not Severity.NOTE)
    if merge and not dry_run:
        patterns = [request.records for request in asked] or [records or sweeps.RECORDS]
        for pattern in dict.fromkeys(patterns):
            for file, count in sweeps.merge(merge, pattern).items():
                say(f"{file.as_posix()} has {count} records", quiet)
    if not experiments:
        return
    commit = _commit()
    wanted = sweeps.Same(same)
    salt = commit or "" if wanted is sweeps.Same.COMMIT else ""
    done = sweeps.recorded(experiments, wanted, commit)
    sweep = sweeps.Sweep(experiments, sweeps.jobs_of(experiments, done, salt), folder)
    say(_summary(sweep, done), quiet)
    if dry_run:
        print(listing(sweep, done))
        return
    for file in dict.fromkeys(one.records for one in experiments):
        prepare(file)
    with _stoppable():
        sweep = sweeps.Sweep(experiments, sweeps.collect(sweep), folder)
        failed: Mapping[str, Outcome] = {}
        if sweep.jobs:
            with guests(), SweepProgress(sweep, quiet) as progress:  # Ray talks on standard output
                failed = sweeps.carry_out(sweep, chosen, progress.watch)
    print(sweeps.table(experiments, sweeps.recorded(experiments, wanted, commit)))
    if failed:
        _tell_failures(sweep, failed)
        raise typer.Exit(1)


def listing(sweep: Sweep, done: Sequence[Mapping[int, object]]) -> str:
    """The jobs that would be done, in their order, then what is recorded already."""
    from tiloilc.sweep.work import RUNS

    lines = []
    for job in sweep.jobs:
        one = sweep.experiments[job.number]
        state = "begun" if (sweep.job_folder(job) / RUNS).is_dir() else "to do"
        about = f"{one.plan.name}  {one.words}  {seeds_of(job.seeds)}  {one.steps:,} steps"
        lines.append(f"{state:<9}{about}")
    for one, records in zip(sweep.experiments, done, strict=True):
        if records:
            count = f"{len(records)} of {len(one.seeds)} seeds"
            lines.append(f"{'recorded':<9}{one.plan.name}  {one.words}  {count}")
    return "\n".join(lines)


def _options(
    algorithms: str | None,
    steps: str | None,
    changes: list[str] | None,
    seeds: int | None,
    first_seed: int | None,
    seeds_per_job: int | None,
    records: str | None,
) -> Options:
    """The options as they hold for every spec. Raises Exit 2 for one that cannot be."""
    from tiloilc.sweep import Options, record_pattern

    try:
        record_pattern(records or "")
    except ValueError as error:
        raise fail(f"--records {error}") from None
    settings = settings_given(changes or [], steps, None)
    for name, option in (("seeds", "--seeds"), ("first_seed", "--first-seed")):
        if name in settings:
            raise fail(f"give `{name}` by {option}")
    if algorithms is not None and "algorithm" in settings:
        raise fail("`algorithm` is given twice: by --set and by --algorithms")
    names = [name.strip() for name in (algorithms or "").split(",")]
    wanted = tuple(dict.fromkeys(name for name in names if name))
    return Options(wanted, checked(settings), seeds, first_seed, seeds_per_job, records)


def _chosen_engine(name: str, workers: int | None, pairs: Sequence[str], folder: Path) -> Engine:
    """The engine, if its library is there. Raises Exit 2 for options that it has not."""
    from tiloilc.sweep import Local, Ray, Slurm
    from tiloilc.sweep import ray as of_ray
    from tiloilc.sweep import slurm as of_slurm

    options = settings_given(pairs, None, None, option="--engine-set")
    if name == "local":
        if options:
            raise fail("--engine-set is for Ray and Slurm")
        return Local(workers or _cores())
    if workers is not None:
        raise fail("--workers is for this machine; a cluster has its own")
    if name == "ray":
        of_ray.require()
        return Ray(options)
    of_slurm.require()
    return Slurm(folder, options)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _commit() -> str | None:
    from tiloilc.evaluate.provenance import git_commit

    return git_commit(Path(tiloilc.__file__).parent)


def _summary(sweep: Sweep, done: Sequence[Mapping[int, object]]) -> str:
    seeds = sum(len(one.seeds) for one in sweep.experiments)
    have, jobs = sum(map(len, done)), len(sweep.jobs)
    return f"{have} of {seeds} seeds are recorded; {jobs} job{'' if jobs == 1 else 's'} to do"


@contextmanager
def _stoppable() -> Iterator[None]:
    """While this lasts, a termination is an interruption, and both end with status 130.

    A shell's background jobs ignore interruptions from birth; a sweep, like `train`, does not.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = {s: signal.signal(s, stop) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    except KeyboardInterrupt:
        say("interrupted; the same command goes on:")
        say(f"  tiloilc {shlex.join(sys.argv[1:])}")
        raise typer.Exit(130) from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _tell_failures(sweep: Sweep, failed: Mapping[str, Outcome]) -> None:
    from tiloilc.sweep.work import LOG

    jobs = {job.id: job for job in sweep.jobs}
    for id, outcome in failed.items():
        job = jobs[id]
        one = sweep.experiments[job.number]
        log = (sweep.job_folder(job) / LOG).as_posix()
        say(f"failed: {one.plan.name} {one.words} {seeds_of(job.seeds)}: {outcome.problem} ({log})")
        for line in outcome.tail:
            say(f"  | {line}")
        say(f"  {shlex.join(sweep.command(job))}")
    say(f"{len(failed)} of {len(sweep.jobs)} jobs failed; the same command tries them again")
