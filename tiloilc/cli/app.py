"""The app: which verbs there are, what is loaded for them, and what happens when one fails.

A verb is a module of this package, or of `logic` if it is about formulas and automata, with a
function `command`, whose signature is its usage and whose docstring is its help; or a package with
a `group` of such commands, which stands last. Modules are imported to show the help, so they import
what is heavy inside their functions. A verb returns nothing and ends otherwise than well by
`raise typer.Exit(status)`, or by letting a CompileError pass.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated, NoReturn

import typer

import tiloilc
from tiloilc.cli.console import report
from tiloilc.diag import CompileError

VERBS = {
    "init": "init",
    "lint": "lint",
    "compile": "compile",
    "train": "train",
    "eval": "evaluate",
    "run": "run",
    "sweep": "sweep",
    "report": "report",
    "verify": "verify",
    "export": "export",
    "viz": "logic.viz",
    "explain": "logic.explain",
    "translate": "logic.translate",
    "check": "logic.check",
    "step": "logic.step",
    "bench": "bench",
    "schema": "schema",
    "doctor": "doctor",
    "demos": "demos",
}
"""The verbs in the order of the help, and the modules they are in."""

TRACEBACK = "TILOILC_TRACEBACK"
"""Set this variable to see where an internal error comes from."""


def build_app(wanted: str | None = None) -> typer.Typer:
    """The app with the verb `wanted` only, or with all of them if there is no such verb."""
    app = typer.Typer(
        name="tiloilc",
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        no_args_is_help=True,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_root)
    for verb in [wanted] if wanted in VERBS else VERBS:
        assert verb is not None
        module = import_module(f"tiloilc.cli.{VERBS[verb]}")
        if hasattr(module, "group"):
            app.add_typer(module.group, name=verb)
        else:
            app.command(verb)(module.command)
    return app


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit: 0 fine, 1 findings, 2 usage, missing file, internal error."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if sys.stdout is None or sys.stderr is None:  # closed by whoever started us
        nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # until the end
        sys.stdout, sys.stderr = sys.stdout or nowhere, sys.stderr or nowhere
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # what its encoding lacks is written as \u2026
            stream.reconfigure(errors="backslashreplace")
    try:
        build_app(next(iter(given), None))(given, prog_name="tiloilc")
    except CompileError as error:
        report(error.diagnostics)
        sys.exit(1)
    except BrokenPipeError:
        # The reader of our output has gone; closing would fail once more while Python exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception as error:
        if os.environ.get(TRACEBACK):
            raise
        if isinstance(error, OSError) and error.strerror is not None:
            name = error.filename2 or error.filename  # of a renaming, where it should go
            what = f"cannot use `{name}`: " if name is not None else ""
            sys.stderr.write(f"error: {what}{error.strerror}\n")
        else:
            sys.stderr.write(_internal(error, given))
        sys.exit(2)
    sys.exit(0)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"tiloilc {tiloilc.__version__}")
        raise typer.Exit


def _root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and exit.", is_eager=True, callback=_version
        ),
    ] = False,
) -> None:
    """Compile a YAML task file with a temporal-logic formula into a trained agent."""


def _internal(error: Exception, given: Sequence[str]) -> str:
    import shlex

    what = f"{type(error).__name__}: {error}".strip().rstrip(":")
    return (
        f"internal error: {what}\n"
        f"This is a fault of tiloilc {tiloilc.__version__}, not of your input. Command:\n"
        f"  {shlex.join(['tiloilc', *given])}\n"
        f"Set {TRACEBACK}=1 to see where it happened, and please report it.\n"
    )
