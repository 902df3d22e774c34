"""`tiloilc schema`: what a task file or a sweep file may say, for editors or for readers."""

from __future__ import annotations

import json
import sys
from typing import Annotated, Literal

import typer

from tiloilc.cli.console import fail


def command(
    file: Annotated[
        Literal["task", "sweep"], typer.Argument(metavar="KIND", help="Which kind of file.")
    ] = "task",
    format: Annotated[
        Literal["json", "markdown"],
        typer.Option(help="json: the schema for editors; markdown: a table of all settings."),
    ] = "json",
) -> None:
    """Print the JSON Schema of task files or of sweep files, or the table of a task's settings."""
    if format == "json":
        schema = _schema(file)
        sys.stdout.write(json.dumps(schema, indent=2, ensure_ascii=False) + "\n")
    elif file == "task":
        from tiloilc.spec import settings_page

        sys.stdout.write(settings_page())
    else:
        raise fail("the table is of task files, whose settings a sweep file changes")


def _schema(file: str) -> dict[str, object]:
    if file == "sweep":
        from tiloilc.sweep import sweep_schema

        return sweep_schema()
    from tiloilc.spec import json_schema

    return json_schema()
