"""`tiloilc viz`: the automaton of a task as a picture."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, fail, say
from tiloilc.cli.tasks import plan_of

SUFFIXES = {
    ".svg": "svg",
    ".png": "png",
    ".dot": "dot",
    ".gv": "dot",
    ".mermaid": "mermaid",
    ".mmd": "mermaid",
}


def command(
    source: Annotated[
        Path, typer.Argument(metavar="SPEC|PLAN", help="A task file or a plan.", exists=True)
    ],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="x.svg, x.png, x.dot or x.mermaid; else dot is printed."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Draw the automaton of a task, with its stages."""
    from tiloilc.automaton import rendered, to_dot, to_mermaid, to_svg
    from tiloilc.driver import write_file

    kind = "dot" if out is None else SUFFIXES.get(out.suffix.lower())
    if kind is None:
        raise fail(f"a picture ends in one of {', '.join(SUFFIXES)}")
    plan = plan_of(source)
    if kind == "png":
        data: str | bytes = rendered(to_dot(plan.ldba, plan.stages, plan.formula), "png")
    else:
        draw = {"svg": to_svg, "dot": to_dot, "mermaid": to_mermaid}[kind]
        data = draw(plan.ldba, plan.stages, plan.formula)
    if out is None:
        assert isinstance(data, str)
        sys.stdout.write(data)
        return
    out.parent.mkdir(parents=True, exist_ok=True)
    write_file(out, data)
    say(f"wrote {out.as_posix()}", quiet)
