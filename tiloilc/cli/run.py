"""`tiloilc run`: from a task file to a report, in one go."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, guests, report, say
from tiloilc.cli.jobs import (
    RUNS,
    evaluate_job,
    new_run,
    open_job,
    run_to_resume,
    train_job,
)
from tiloilc.cli.settings import demonstrations_given, settings_given
from tiloilc.cli.train import Device, Resume, Runs, Seeds, Set, Steps
from tiloilc.cli.verdict import verdict

Record = Annotated[
    Path | None,
    typer.Option("--record", metavar="FILE", help="Append a record of each seed to .jsonl.gz."),
]


def command(
    spec: Annotated[
        Path, typer.Argument(metavar="SPEC", help="The task file, or a build folder.", exists=True)
    ],
    steps: Steps = None,
    seeds: Seeds = None,
    device: Device = None,
    changes: Set = None,
    resume: Resume = False,
    runs: Runs = RUNS,
    record: Record = None,
    quiet: Quiet = False,
) -> None:
    """Compile, train, evaluate and report in one go.

    Settings whose names begin with `demonstrations.` are laid over the task file's demonstrations.

    Prints what the policies achieve beside the optimum, and where the report is.
    """
    from tiloilc.driver import compile_spec, write_build
    from tiloilc.evaluate import append, prepare, records_of_run
    from tiloilc.plan import digest
    from tiloilc.report import write_report

    if record is not None:
        prepare(record)
    settings = settings_given(changes or [], steps, seeds, device)
    build = spec
    if not spec.is_dir():
        laid = demonstrations_given(settings)
        with guests():
            result = compile_spec(spec, laid)
        if not quiet:
            report(result.diagnostics)
        name = result.plan.name
        # what the task file does not say has a folder of its own: `build/NAME` is what it says
        build = Path("build") / (f"{name}-{digest(result.plan)[:12]}" if laid.values else name)
        write_build(result, build)
        say(f"compiled to {build.as_posix()}", quiet)
    with open_job(build, settings, quiet) as job:
        run = run_to_resume(build, job, runs) if resume else new_run(job, runs)
        seconds = train_job(job, run, resume, quiet)
        say(f"trained in {seconds:.0f} s; evaluating", quiet)
        evaluation = evaluate_job(job, run, None)
        page = write_report([run], run / "report.html")
    print(verdict(evaluation))
    print(f"report: {page.as_posix()}")
    if record is not None:
        append(record, records_of_run(run))
