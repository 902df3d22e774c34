"""`tiloilc lint`: every finding of task files, without training."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, guests, report, say
from tiloilc.diag import FORMATS, exit_status


class Deny(StrEnum):
    """What else than errors makes the exit status 1."""

    WARNINGS = "warnings"


def _format(value: str) -> str:
    if value not in FORMATS:
        raise typer.BadParameter(f"one of {', '.join(FORMATS)}")
    return value


def command(
    specs: Annotated[
        list[Path],
        typer.Argument(metavar="SPEC", help="Task files.", exists=True, dir_okay=False),
    ],
    format: Annotated[
        str, typer.Option(callback=_format, help=f"One of {', '.join(FORMATS)}.")
    ] = "text",
    deny: Annotated[
        Deny | None, typer.Option(metavar="warnings", help="Exit with 1 for warnings too.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Print all findings of task files.

    Exit with 1 if there is an error.
    """
    from tiloilc.driver import lint

    with guests():
        found = [diagnostic for spec in specs for diagnostic in lint(spec)]
    report(found, format, sys.stdout)
    if not found:
        say("no findings", quiet)
    status = exit_status(found, deny_warnings=deny is Deny.WARNINGS)
    if status:
        raise typer.Exit(status)
