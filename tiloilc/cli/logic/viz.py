"""`tiloilc viz`: an automaton as a picture, or as a page to play with."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, checked_suffix, fail, report, say
from tiloilc.cli.logic.formulas import Propositions
from tiloilc.cli.logic.subjects import Subject, subject_of
from tiloilc.cli.tasks import prepare_drawing
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
        list[str],
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
    env: Annotated[
        bool,
        typer.Option("--env", help="Draw the environment instead; several tasks make a sheet."),
    ] = False,
    demo: Annotated[
        int, typer.Option(min=0, metavar="K", help="With --env: demonstration K, from 0.")
    ] = 0,
    propositions: Propositions = None,
    quiet: Quiet = False,
) -> None:
    """Draw an automaton with its stages, or an environment with a demonstration.

    A page (x.html) is interactive: letters and words are read by click, the run is shown. With
    --env the path of a demonstration has the colours of the automaton's states; x.svg or x.png,
    else svg is printed.
    """
    from tiloilc.writing import write_file

    if env:
        _environments(source, demo, out, quiet)
        return
    if len(source) > 1:
        raise fail("one automaton at a time; several tasks are drawn with --env")
    kind = "dot" if out is None else SUFFIXES.get(out.suffix.lower())
    if kind is None:
        assert out is not None
        report([_unknown(out)])
        raise typer.Exit(2)
    drawn = _drawn(subject_of(source[0], propositions), kind)
    if out is None:
        assert isinstance(drawn, str)
        sys.stdout.write(drawn)
        return
    out.parent.mkdir(parents=True, exist_ok=True)
    write_file(out, drawn)
    say(f"wrote {out.as_posix()}", quiet)


def _environments(sources: Sequence[str], demo: int, out: Path | None, quiet: bool) -> None:
    from tiloilc.cli.logic.places import environment_drawn
    from tiloilc.report.pictures import png_of, svg_of
    from tiloilc.writing import write_file

    kind = ".svg"
    if out is not None:
        kind = checked_suffix(out, "an environment is drawn as", ".svg", ".png")
    prepare_drawing()
    canvas = environment_drawn(sources, demo)
    if out is None:
        sys.stdout.write(svg_of(canvas))
        return
    out.parent.mkdir(parents=True, exist_ok=True)
    write_file(out, svg_of(canvas) if kind == ".svg" else png_of(canvas))
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
