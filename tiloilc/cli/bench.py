"""`tiloilc bench`: the project's own benchmarks."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import Quiet, fail, say

if TYPE_CHECKING:
    from tiloilc.bench import Reference, Row

DATA = Path("../shared/data/ltl")
"""Where the published sizes are looked for: beside the checkout."""

VARIABLE = "TILOILC_LTL_DATA"


class Part(StrEnum):
    """What can be measured."""

    AUTOMATA = "automata"


def command(
    part: Annotated[Part, typer.Argument(help="What to measure.")] = Part.AUTOMATA,
    data: Annotated[
        Path | None,
        typer.Option(
            help=f"The folder with reference_sizes.csv; {DATA.as_posix()} if it is there.",
            envvar=VARIABLE,
            file_okay=False,
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the page here.", dir_okay=False)
    ] = None,
    table: Annotated[
        bool, typer.Option("--csv", help="Each formula of the sets in a row, instead of a page.")
    ] = False,
    runs: Annotated[int, typer.Option(min=1, help="Translations of each formula.")] = 3,
    quiet: Quiet = False,
) -> None:
    """Measure sizes and times of automata beside published ones, as a page of Markdown."""
    from tiloilc.bench import BOMBS, PAPER, automata_page, measure_alone, measure_known

    assert part is Part.AUTOMATA, "there is no other"
    references = _references(data, needed=table or output is not None, quiet=quiet)
    if table:
        _csv(_measured(references, runs, quiet))
        return
    literature = list(_measured(references, runs, quiet))
    paper = list(measure_known(PAPER, runs))
    bombs = []
    for bomb in measure_alone(BOMBS):
        say(f"{bomb.name}: {bomb.measured.ms / 1000:.1f} s, {bomb.peak:.0f} MiB", quiet)
        bombs.append(bomb)
    page = automata_page(literature, paper, bombs, runs)
    if output is None:
        sys.stdout.write(page)
    else:
        output.write_text(page, encoding="utf-8", newline="\n")
        say(f"wrote {output.as_posix()}", quiet)


def _references(data: Path | None, needed: bool, quiet: bool) -> tuple[Reference, ...]:
    """The published sizes; none where nobody said where they are and they are not beside us."""
    from tiloilc.bench import BadReferences, read_references

    if data is None and not DATA.is_dir():
        missing = f"no published sizes in `{DATA.as_posix()}`; give --data DIR or set {VARIABLE}"
        if needed:
            raise fail(missing)
        say(f"{missing}. Without them: the paper's formulas only.", quiet)
        return ()
    try:
        return read_references(data or DATA)
    except BadReferences as error:
        raise fail(str(error)) from None


def _measured(references: tuple[Reference, ...], runs: int, quiet: bool) -> Iterator[Row]:
    from tiloilc.bench import measure_set

    for done, row in enumerate(measure_set(references, runs), 1):
        yield row
        if done % 50 == 0 or done == len(references):
            say(f"{done} of {len(references)} formulas", quiet)


def _csv(rows: Iterator[Row]) -> None:
    from tiloilc.bench.automata.references import COLUMNS

    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow([*COLUMNS, "edge", "state", "jumps", "ms"])
    for row in rows:
        assert row.reference is not None
        known = row.name, row.formula, *row.reference.sizes, row.best
        sizes = ["" if m.code else m.states for m in (row.edge, row.state)]
        writer.writerow([*known, *sizes, row.edge.jumps, f"{row.edge.ms:.2f}"])
        sys.stdout.flush()
