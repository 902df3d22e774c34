"""`tiloilc report`: one self-contained HTML page from run folders."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, checked_suffix, fail, guests, say

Runs = Annotated[
    list[Path], typer.Argument(metavar="RUN", help="Run folders; several are compared.")
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="Where to write [one run: report.html in its folder; several: ./report.html].",
        show_default=False,
    ),
]


def command(runs: Runs, output: Out = None, quiet: Quiet = False) -> None:
    """Write one HTML page of one or several runs.

    Prints its path. Curves with intervals, the automaton, stage occupancy, trajectories, settings
    and how to reproduce them; the page needs no network.
    """
    for run in runs:
        if not run.is_dir():
            raise fail(f"no run folder `{run}`")
    if output is not None and output.is_dir():
        raise fail(f"`{output}` is a folder; name a file in it")
    if output is not None:
        checked_suffix(output, "a report is", ".html", ".htm")

    from tiloilc.report import write_report

    out = output or (runs[0] / "report.html" if len(runs) == 1 else Path("report.html"))
    say(f"reading {len(runs)} run{'' if len(runs) == 1 else 's'}", quiet)
    with guests():  # maps are asked of environments
        written = write_report(runs, out)
    print(written)
