"""What the verbs about formulas share: reading them, words, failing at a place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import coloured, fail
from tiloilc.diag import Diagnostic, SourceText, render

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
    """`a, b` as names; None stays None. Raises Exit 2 for a name that is empty or given twice."""
    if names is None:
        return None
    split = tuple(name.strip() for name in names.split(","))
    if "" in split:
        raise fail(f"--propositions {names}: a name is empty")
    if twice := [name for i, name in enumerate(split) if name in split[:i]]:
        raise fail(f"--propositions {names}: `{twice[0]}` is given twice")
    return split


@dataclass(frozen=True, slots=True)
class Written:
    """A formula that stands in no task file: on the command line, or in a line of a file."""

    text: str
    file: str = "<formula>"
    line: int = 1

    @property
    def name(self) -> str:
        """The formula without the spaces around it."""
        return self.text.strip()

    @property
    def source(self) -> SourceText:
        """The formula with its places."""
        plain = SourceText.plain(self.text, self.file)
        places = tuple((line + self.line - 1, column) for line, column in plain.places)
        return SourceText(self.text, self.file, places)


def read(written: Written, names: str | None = None) -> Parsed:
    """Parse a formula; its warnings are shown.

    Raises CompileError, to be shown with `show`.
    """
    from tiloilc.ltl import parse

    parsed = parse(written.source, split_names(names))
    show(parsed.warnings, written)
    return parsed


def show(diagnostics: tuple[Diagnostic, ...], written: Written) -> None:
    """Findings about a formula, with an excerpt of it, on standard error.

    Those without a place are about the whole formula.
    """
    import sys
    from dataclasses import replace

    sources = {written.file: "\n" * (written.line - 1) + written.text}
    placed = [replace(d, span=d.span or written.source.span()) for d in diagnostics]
    sys.stderr.write(render(placed, "text", sources, colour=coloured(sys.stderr)))
