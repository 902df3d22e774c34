"""`tiloilc demos record`: an expert acts, and what it does is kept."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, guests, report, say
from tiloilc.cli.tasks import demonstrations_file, task_file
from tiloilc.diag import CompileError


def command(
    spec: Annotated[
        str, typer.Argument(metavar="SPEC", help="A task file, or the name of a bundled one.")
    ],
    episodes: Annotated[
        int, typer.Option("--episodes", "-n", min=1, max=100_000, help="How many are kept.")
    ] = 5,
    noise: Annotated[
        float | None,
        typer.Option(min=0.0, max=1.0, help="Disturbs its actions; 0: none [the expert's own]."),
    ] = None,
    laps: Annotated[
        int | None, typer.Option(min=1, help="Rounds that it makes [the expert's own].")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the first episode.")] = 0,
    expert: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.py:FUNCTION",
            help="One of the environment's experts, or your own [the one that fits the formula].",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The .npz to write; else <name>.npz.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Record demonstrations with an expert.

    Writes an .npz of states and actions and a JSON beside it, and prints the path. Of several
    experts of an environment the one is taken that the task's automaton accepts most often.
    """
    from tiloilc.demos import DemoSet, record, record_best, save
    from tiloilc.driver import analyse
    from tiloilc.plan import importable

    target = None if out is None else demonstrations_file(out)
    path = task_file(spec)
    with guests():
        task = analyse(path, DemoSet(()))
    if task.failed:
        raise CompileError(*task.diagnostics)
    assert task.spec is not None
    assert task.labels is not None
    assert task.ldba is not None
    target = target or demonstrations_file(Path(f"{task.spec.name}.npz"))
    environment = task.spec.environment
    with importable(path.parent), guests():
        if expert is None:
            demos = record_best(
                environment,
                task.labels,
                task.ldba,
                name=task.spec.name,
                count=episodes,
                seed=seed,
                noise=noise,
                laps=laps,
            )
        else:
            demos = record(
                environment.id,
                environment.kwargs,
                horizon=environment.horizon,
                expert=expert,
                count=episodes,
                seed=seed,
                noise=noise,
                laps=laps,
            )
    if not quiet:
        with guests():
            found = analyse(path, demos).diagnostics
        report(d for d in found if d.code.startswith("DEMO"))
    target.parent.mkdir(parents=True, exist_ok=True)
    save(target, demos)
    steps = sum(demo.steps for demo in demos.episodes)
    say(f"{len(demos)} episodes, {steps} steps, by `{demos.meta['expert']}`", quiet)
    print(target.as_posix())
