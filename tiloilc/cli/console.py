"""Where output goes: data on standard output, talk on standard error, files all or nothing."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Annotated, TextIO

import typer

from tiloilc.diag import Diagnostic, render

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Only data and errors.")]
"""The option that every verb with something to say has."""


def say(text: str, quiet: bool = False) -> None:
    """One line of talk, unless the user wants none."""
    if not quiet:
        print(text, file=sys.stderr)


def fail(text: str) -> typer.Exit:
    """A usage error in our own words; to be raised."""
    print(f"error: {text}", file=sys.stderr)
    return typer.Exit(2)


def checked_suffix(path: Path, what: str, *known: str) -> str:
    """The suffix of a file to be written, in small letters. Raises Exit 2 if it is not `known`."""
    suffix = path.suffix.lower()
    if suffix not in known:
        names = " or ".join(f"x{one}" for one in known)
        raise fail(f"{what} {names}, not `{path.as_posix()}`")
    return suffix


@contextmanager
def guests() -> Iterator[None]:
    """While this lasts, the code of others runs: an environment, a predicate in Python.

    What it writes to standard output, by print or from a library in C, goes to standard error:
    standard output is for results.
    """
    sys.stdout.flush()
    try:
        ours = os.dup(1)
    except OSError:  # closed by whoever started us
        with redirect_stdout(sys.stderr):
            yield
        return
    try:
        os.dup2(2, 1)
        with redirect_stdout(sys.stderr):
            yield
    finally:
        os.dup2(ours, 1)
        os.close(ours)


def coloured(stream: TextIO) -> bool:
    """Whether `stream` shows colours: a terminal, and the user does not object."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def sources(diagnostics: Iterable[Diagnostic]) -> dict[str, str]:
    """The text of each file that `diagnostics` point into, as far as it can be read."""
    texts = {}
    for file in {d.span.file for d in diagnostics if d.span is not None}:
        try:
            texts[file] = Path(file).read_text(encoding="utf-8")
        except (OSError, ValueError):
            continue
    return texts


def report(
    diagnostics: Iterable[Diagnostic], format: str = "text", stream: TextIO | None = None
) -> None:
    """Write findings, to standard error unless told otherwise."""
    found, out = list(diagnostics), stream or sys.stderr
    out.write(render(found, format, sources(found), colour=coloured(out)))
