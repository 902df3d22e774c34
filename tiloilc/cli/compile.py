"""`tiloilc compile`: a task file to a build folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, guests, report, say


def command(
    spec: Annotated[
        Path, typer.Argument(metavar="SPEC", help="The task file.", exists=True, dir_okay=False)
    ],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The folder; else build/<name>.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compile a task file to a plan that can be trained.

    Writes the plan, the automaton and its picture, the demonstrations and a job to a folder, and
    prints the folder.
    """
    from tiloilc.driver import compile_spec, write_build

    with guests():
        result = compile_spec(spec)
    if not quiet:
        report(result.diagnostics)
    folder = out or Path("build") / result.plan.name
    write_build(result, folder)
    live = len(result.plan.ldba.names) - (result.plan.ldba.sink is not None)
    say(f"{result.plan.name}: {live} live states, {len(result.demos)} demonstrations", quiet)
    print(folder.as_posix())
