"""`tiloilc bench`: the project's own benchmarks."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator, Mapping
from enum import StrEnum
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import Quiet, fail, say

if TYPE_CHECKING:
    from tiloilc.bench import Measurement, Reference, Row
    from tiloilc.bench.turns import Tell

DATA = Path("../shared/data/ltl")
"""Where the published sizes are looked for: beside the checkout."""

VARIABLE = "TILOILC_LTL_DATA"

GOALS, SIZES = "benchmarks.md", "automaton_sizes.md"


class Part(StrEnum):
    """What can be measured: the modules of `tiloilc.bench`, and automata, in their order."""

    SAC = "sac"
    STACKED = "stacked"
    LOOP = "loop"
    ENVS = "envs"
    COLD = "cold"
    MEMORY = "memory"
    TASKS = "tasks"
    AUTOMATA = "automata"


def command(
    only: Annotated[
        list[Part] | None, typer.Option("--only", help="Only this part; may be repeated.")
    ] = None,
    as_json: Annotated[
        bool,
        typer.Option(
            "--json", help="A list of name, value, unit, against, ratio, goal, instead of a page."
        ),
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help=f"Write {GOALS} and {SIZES} into this folder.", file_okay=False
        ),
    ] = None,
    rounds: Annotated[
        int, typer.Option(min=1, help="Turns of each of those that are compared.")
    ] = 15,
    data: Annotated[
        Path | None,
        typer.Option(
            help=f"The folder with reference_sizes.csv; {DATA.as_posix()} if it is there.",
            envvar=VARIABLE,
            file_okay=False,
        ),
    ] = None,
    table: Annotated[
        bool, typer.Option("--csv", help="Each formula of the sets in a row, and nothing else.")
    ] = False,
    runs: Annotated[int, typer.Option(min=1, help="Translations of each formula.")] = 3,
    quiet: Quiet = False,
) -> None:
    """Measure learning, environments, commands and automata beside others and against goals."""
    parts = [part for part in Part if part in (only or Part)]
    learning = [part for part in parts if part is not Part.AUTOMATA]
    if output is not None and learning and len(parts) < len(Part):
        raise fail(f"`-o` writes whole pages: without --only, or with --only {Part.AUTOMATA}")
    references: tuple[Reference, ...] = ()
    if table or Part.AUTOMATA in parts:
        needed = table or output is not None
        references = _references(data, needed=needed, quiet=quiet)
    if table:
        _csv(_measured(references, runs, quiet))
        return
    tell = partial(say, quiet=quiet)
    found = {str(part): _learning(part, rounds, tell) for part in learning}
    pages = {}
    if Part.AUTOMATA in parts:
        found[Part.AUTOMATA], pages[SIZES] = _automata(references, runs, as_json, quiet)
    if as_json:
        rows = [row.to_json() for part in found.values() for row in part]
        sys.stdout.write(json.dumps(rows, indent=1, ensure_ascii=False) + "\n")
        return
    if learning:
        pages = {GOALS: _goals(found, tell), **pages}
    if output is None:
        sys.stdout.write("\n".join(pages.values()))
        return
    output.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        (output / name).write_text(text, encoding="utf-8", newline="\n")
        tell(f"wrote {(output / name).as_posix()}")


def _learning(part: Part, rounds: int, tell: Tell) -> list[Measurement]:
    measured: list[Measurement] = import_module(f"tiloilc.bench.{part}").measure(rounds, tell)
    return measured


def _goals(found: Mapping[str, list[Measurement]], tell: Tell) -> str:
    """The page of the table of goals; profiles are on it where updates were measured."""
    from tiloilc.bench.page import benchmarks_page
    from tiloilc.bench.sac import OURS_JUDGED
    from tiloilc.bench.stacked import OURS
    from tiloilc.bench.turns import profile, versions

    ours = {"One seed, K = 4": (Part.SAC, OURS_JUDGED), "Ten seeds, 64 wide": (Part.STACKED, OURS)}
    profiles = {title: profile(one.work) for title, (part, one) in ours.items() if part in found}
    return benchmarks_page(found, profiles, versions())


def _automata(
    references: tuple[Reference, ...], runs: int, brief: bool, quiet: bool
) -> tuple[list[Measurement], str]:
    """The rows in the table of goals, and the page of sizes unless that is not wanted."""
    from tiloilc.bench import (
        BOMBS,
        PAPER,
        automata_page,
        measure_alone,
        measure_known,
        measurements,
    )

    literature = list(_measured(references, runs, quiet))
    rows = measurements(literature)
    if brief:
        return rows, ""
    paper = list(measure_known(PAPER, runs))
    bombs = []
    for bomb in measure_alone(BOMBS):
        say(f"{bomb.name}: {bomb.measured.ms / 1000:.1f} s, {bomb.peak:.0f} MiB", quiet)
        bombs.append(bomb)
    return rows, automata_page(literature, paper, bombs, runs)


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
