"""`tiloilc train`: a plan to a run folder with trained policies."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet
from tiloilc.cli.jobs import RUNS, new_run, open_job, run_to_resume, train_job
from tiloilc.cli.settings import settings_given

Steps = Annotated[
    str | None, typer.Option("--steps", help="Environment steps per seed, instead of the plan's.")
]
Seeds = Annotated[int | None, typer.Option("--seeds", min=1, help="Agents, instead of the plan's.")]
Device = Annotated[
    str | None, typer.Option("--device", metavar="auto|cpu|cuda", help="Where networks learn.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Change a setting; may be repeated."),
]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with an unfinished run.")]
Runs = Annotated[Path, typer.Option("--runs", help="Where run folders are.")]


def command(
    plan: Annotated[
        Path, typer.Argument(metavar="PLAN", help="A build folder, a plan, or a run.", exists=True)
    ],
    steps: Steps = None,
    seeds: Seeds = None,
    device: Device = None,
    changes: Set = None,
    resume: Resume = False,
    runs: Runs = RUNS,
    quiet: Quiet = False,
) -> None:
    """Train the agents of a compiled plan.

    All seeds learn in one program. Prints the run folder. Ctrl-C writes a checkpoint and says how
    to go on.
    """
    with open_job(plan, settings_given(changes or [], steps, seeds, device), quiet) as job:
        run = run_to_resume(plan, job, runs) if resume else new_run(job, runs)
        train_job(job, run, resume, quiet)
    print(run.as_posix())
