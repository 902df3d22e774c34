"""`tiloilc viz`: an automaton as a picture, or as a page to play with."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, report, say
from tiloilc.cli.logic.formulas import Propositions
from tiloilc.cli.logic.subjects import Subject, subject_of
from tiloilc.diag import CompileError, Diagnostic

SUFFIXES = {
    ".svg": "svg",
    ".png": "png",
    ".html": "html",
    ".htm": "html",
    ".dot": "dot",
    ".gv": "dot",
    ".mermaid": "mermaid",
    ".mmd": "mermaid",
}


def command(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SPEC|PLAN|HOA|FORMULA",
            help="A task file, a build folder or plan, an automaton, or a formula.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", help="x.svg, x.png, x.html, x.dot or x.mermaid; else dot is printed."
        ),
    ] = None,
    propositions: Propositions = None,
    quiet: Quiet = False,
) -> None:
    """Draw an automaton with its stages.

    A page (x.html) is interactive: letters and words are read by click, the run is shown.
    """
    from tiloilc.driver import write_file

    kind = "dot" if out is None else SUFFIXES.get(out.suffix.lower())
    if kind is None:
        assert out is not None
        report([_unknown(out)])
        raise typer.Exit(2)
    drawn = _drawn(subject_of(source, propositions), kind)
    if out is None:
        assert isinstance(drawn, str)
        sys.stdout.write(drawn)
        return
    out.parent.mkdir(parents=True, exist_ok=True)
    write_file(out, drawn)
    say(f"wrote {out.as_posix()}", quiet)


def _unknown(out: Path) -> Diagnostic:
    suffix = f"`{out.suffix}`" if out.suffix else f"`{out.name}`, which has no suffix,"
    problem = f"{suffix} is no format of pictures"
    return Diagnostic.of("AUT310", problem=problem, help=f"use one of {', '.join(SUFFIXES)}")


def _drawn(known: Subject, kind: str) -> str | bytes:
    from tiloilc.automaton import to_dot, to_html, to_mermaid, to_png, to_svg
    from tiloilc.automaton.drawing.picture.compose import too_large

    about = known.ldba, known.stages, known.title
    if kind in ("svg", "png") and (why := too_large(known.ldba)):
        help = "write .html or .dot instead"
        raise CompileError(Diagnostic.of("AUT310", problem=why, help=help))
    if kind == "png":
        return to_png(*about)
    if kind == "html":
        return to_html(*about, told=_told(known))
    return {"svg": to_svg, "dot": to_dot, "mermaid": to_mermaid}[kind](*about)


def _told(known: Subject) -> list[str]:
    """Each state in words, as `explain` says them."""
    from tiloilc.plan.sentences import sentence
    from tiloilc.plan.telling import Teller

    if known.stages is None:
        return []
    ldba, teller = known.ldba, Teller(known.ldba, known.stages)
    return ["" if b == ldba.sink else sentence(teller, b) for b in ldba.states]
