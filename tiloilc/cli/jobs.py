"""What train, eval and run share: a plan with its inputs, run folders."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tiloilc
from tiloilc.cli.console import fail, guests, say
from tiloilc.cli.settings import changed
from tiloilc.diag import counted

if TYPE_CHECKING:
    from tiloilc.demos import DemoSet
    from tiloilc.label import Labeller
    from tiloilc.plan import Plan
    from tiloilc.spec import Settings

RUNS = Path("runs")
TIMING, EVENTS = "timing.json", "events.jsonl"
COPIED = ("demos.npz", "demos.json", "automaton.svg", "automaton.hoa")
"""What a run takes along from the build folder, so that it stands on its own."""


CHANGES_SHOWN = 3
"""Settings that are named where a run was trained with others."""


@dataclass(frozen=True, eq=False)
class Job:
    """A plan that can be run: with its demonstrations and its propositions as a function."""

    plan: Plan
    demos: DemoSet
    labels: Labeller
    folder: Path


@contextmanager
def open_job(
    folder: Path, changes: Mapping[str, object] | None = None, quiet: bool = False
) -> Iterator[Job]:
    """The job of a build or run folder, with changed settings.

    While this lasts, modules beside the task file can be imported, and what they print goes to
    standard error. Raises CompileError with what is
    wrong with the changed settings; says what is strange about them, unless `quiet`.
    """
    from tiloilc.demos import DemoSet, load
    from tiloilc.driver import labeller, load_plan, plan_file
    from tiloilc.plan import importable

    if folder.suffix.lower() in (".yaml", ".yml") and folder.is_file():
        name = folder.as_posix()
        raise fail(f"`{name}` is a task file; compile it first, or: tiloilc run {name}")
    if not plan_file(folder).is_file():
        raise fail(f"no plan in `{folder.as_posix()}`; compile a task file first")
    plan = load_plan(folder, of_run=(plan_file(folder).parent / EVENTS).is_file())
    if changes:
        plan = dataclasses.replace(plan, train=changed(plan, changes, quiet))
    where = plan_file(folder).parent
    file = where / "demos.npz"
    with importable(plan.root), guests():
        demos = load(file) if file.is_file() else DemoSet(())
        yield Job(plan, demos, labeller(plan), where)


def new_run(job: Job, runs: Path) -> Path:
    """A fresh run folder `runs/<name>/<number>` that holds the plan and its inputs."""
    from tiloilc.driver import write_plan

    parent = runs / job.plan.name
    parent.mkdir(parents=True, exist_ok=True)
    number = max((int(p.name) for p in parent.iterdir() if p.name.isdigit()), default=0)
    while True:
        number += 1
        run = parent / f"{number:04d}"
        try:
            run.mkdir()
            break
        except FileExistsError:
            continue
    (run / EVENTS).touch()  # a run from now on: it can be resumed whenever it is killed
    for name in COPIED:
        if (job.folder / name).is_file():
            shutil.copyfile(job.folder / name, run / name)
    write_plan(job.plan, run / "plan.json")
    return run


def run_to_resume(folder: Path, job: Job, runs: Path) -> Path:
    """The run that `--resume` means: the folder itself if it is one, else this plan's newest.

    Raises CompileError RUN704 if the folder is a run of other settings.
    """
    from tiloilc.diag import CompileError, Diagnostic
    from tiloilc.driver import read_plan
    from tiloilc.plan import digest

    if (folder / EVENTS).is_file():
        if other := _changes(read_plan(folder).train, job.plan.train):
            help, other = "without these options it goes on", f"other settings: {other}"
            path = folder.as_posix()
            raise CompileError(Diagnostic.of("RUN704", help=help, path=path, other=other))
        return folder
    parent, newest = runs / job.plan.name, ""
    wanted = digest(job.plan)
    found = sorted(p.parent for p in parent.glob("[0-9]*/plan.json")) if parent.is_dir() else []
    for run in reversed(found):
        try:
            plan = read_plan(run)
        except CompileError:  # damaged, or of another version: it cannot be meant
            continue
        if digest(plan) == wanted:
            return run
        newest = newest or f"; `{run.as_posix()}` was trained with {_other(plan, job.plan)}"
    raise fail(f"no run of this plan in `{parent.as_posix()}` to go on with{newest}")


def _other(before: Plan, now: Plan) -> str:
    """How a run's plan differs, in words."""
    changes = _changes(before.train, now.train)
    return f"other settings: {changes}" if changes else "another task file"


def _changes(before: Settings, now: Settings) -> str:
    """What is not as it was, in words: the first few settings."""
    was, given = before.model_dump(), now.model_dump()
    words = [f"{k} {_told(was[k])}, not {_told(v)}" for k, v in given.items() if v != was[k]]
    return "; ".join(words[:CHANGES_SHOWN]) + ("; …" if len(words) > CHANGES_SHOWN else "")


def _told(value: object) -> str:
    return f"{value:,}" if type(value) is int else json.dumps(value).strip('"')


def train_job(job: Job, run: Path, resume: bool, quiet: bool) -> float:
    """Train in `run`, with progress on standard error; the seconds spent in all.

    Raises Exit 130 when interrupted, after saying how to go on.
    """
    import typer

    agents = counted(job.plan.train.seeds, "seed")
    say(f"training {job.plan.name}: {agents} in {run.as_posix()}", quiet)
    with _alone(run), _swept(run, resume):
        from tiloilc.cli.progress import Progress
        from tiloilc.evaluate.protocol import Validator
        from tiloilc.evaluate.provenance import versions
        from tiloilc.learn import train
        from tiloilc.plan import digest

        settings = job.plan.train
        about = {
            "name": job.plan.name,
            "plan_digest": digest(job.plan),
            "algorithm": settings.algorithm,
            "preset": settings.preset,
            "seeds": list(range(settings.first_seed, settings.first_seed + settings.seeds)),
            "overrides": settings.overrides(),
            "versions": versions(),
        }
        validator = Validator(job.plan, job.labels)
        with Progress(job.plan, quiet) as progress:
            outcome = train(
                job.plan, job.demos, job.labels, run, validator, progress.watch, about, resume,
                lambda text: say(text, quiet),
            )  # fmt: skip
    _write_json(run / TIMING, {"seconds": round(outcome.seconds, 3)})
    if outcome.interrupted:
        say(f"interrupted at step {outcome.step} of {outcome.steps}; go on with:")
        say(f"  tiloilc train {run.as_posix()} --resume")
        raise typer.Exit(130)
    return outcome.seconds


@contextmanager
def _swept(run: Path, resume: bool) -> Iterator[None]:
    """Remove a new run folder if nothing happens in it: stopped or failed before it began."""
    try:
        yield
    except BaseException:
        if not resume and (run / EVENTS).stat().st_size == 0:
            shutil.rmtree(run)
        raise


@contextmanager
def _alone(run: Path) -> Iterator[None]:
    """Hold the run folder: two logs in one are none. Raises Exit 2 if another process does."""
    from tiloilc.evaluate.alone import alone

    with ExitStack() as held:
        try:
            held.enter_context(alone(run, wait=False))
        except BlockingIOError:
            raise fail(f"`{run.as_posix()}` is being trained by another process") from None
        yield


def evaluate_job(job: Job, run: Path, episodes: int | None) -> dict[str, object]:
    """Evaluate a finished run by the protocol; writes `eval.json` and arrays, returns it."""
    import io

    import numpy as np

    from tiloilc.evaluate import protocol, provenance
    from tiloilc.evaluate.landscape import REWARDS, landscape
    from tiloilc.writing import write_file

    source = Path(tiloilc.__file__).parent
    about = {
        "overrides": job.plan.train.overrides(),
        "wall_seconds": _spent(run),
        "machine": provenance.machine(),
        "versions": provenance.versions(),
        "git_commit": provenance.git_commit(source),
        "git_time": provenance.git_time(source),
    }
    evaluation, trajectories = protocol.evaluate_run(
        job.plan, job.demos, job.labels, run, episodes or job.plan.evaluate.episodes, about
    )
    arrays = {
        protocol.TRAJECTORIES: trajectories,
        REWARDS: landscape(job.plan, job.demos, job.labels, run),
    }
    for name, found in arrays.items():
        if found:
            buffer = io.BytesIO()
            np.savez_compressed(buffer, allow_pickle=False, **found)
            write_file(run / name, buffer.getvalue())
    write_file(run / protocol.EVAL, protocol.dump(evaluation))
    return evaluation


def _spent(run: Path) -> float:
    try:
        return float(json.loads((run / TIMING).read_text(encoding="utf-8"))["seconds"])
    except (OSError, ValueError, KeyError, TypeError):
        return 0.0


def _write_json(path: Path, value: Mapping[str, object]) -> None:
    from tiloilc.writing import write_file

    write_file(path, json.dumps(value) + "\n")
