"""`tiloilc schema`: what a task file may say, for editors or for readers."""

from __future__ import annotations

import json
import sys
from typing import Annotated, Literal

import typer


def command(
    format: Annotated[
        Literal["json", "markdown"],
        typer.Option(help="json: the schema for editors; markdown: a table of all settings."),
    ] = "json",
) -> None:
    """Print the JSON Schema of the task file, or the table of its settings."""
    from tiloilc.spec import json_schema, settings_page

    if format == "markdown":
        sys.stdout.write(settings_page())
    else:
        sys.stdout.write(json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n")
