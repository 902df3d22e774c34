"""What the verbs about formulas share: reading them, words, failing at a place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.diag import CompileError, Diagnostic, SourceText, render

if TYPE_CHECKING:
    from tiloilc.ltl import Parsed

Propositions = Annotated[
    str | None,
    typer.Option(
        "--propositions",
        metavar="A,B,...",
        help="Declared propositions, in the order of the bits; else as they appear.",
    ),
]
"""The option that fixes the propositions."""


def split_names(names: str | None) -> tuple[str, ...] | None:
    """`a, b` as names; None stays None."""
    return None if names is None else tuple(name.strip() for name in names.split(",") if name)


def read(text: str, names: str | None = None, file: str = "<formula>") -> Parsed:
    """A formula given on the command line; its findings show an excerpt of it.

    Warnings are written to standard error. An error ends the program with status 1.
    """
    import sys

    from tiloilc.ltl import parse

    source = SourceText.plain(text, file)
    try:
        parsed = parse(source, split_names(names))
    except CompileError as error:
        show(error.diagnostics, text, file)
        raise typer.Exit(1) from None
    if parsed.warnings:
        sys.stderr.write(render(parsed.warnings, "text", {file: text}))
    return parsed


def show(diagnostics: tuple[Diagnostic, ...], text: str, file: str = "<formula>") -> None:
    """Findings about a formula that stands in no file, on standard error."""
    import sys

    from tiloilc.cli.console import coloured

    sys.stderr.write(render(diagnostics, "text", {file: text}, colour=coloured(sys.stderr)))
