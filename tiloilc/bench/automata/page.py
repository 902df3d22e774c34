"""What the benchmark of automata has found, as one page of Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.bench.automata.measure import LIMITS, Alone, Figures, Measured, Row
from tiloilc.bench.automata.references import VARIANTS
from tiloilc.bench.markdown import machine, table

HEAD = """\
# Sizes of automata

Written by `make bench`, not by hand. Sizes are reachable states without the sink; *edge* is with
marked edges, *state* with accepting states. What is compared with others is edge-based acceptance,
with ε-jumps expanded or not counted as states, which are the terms of the published sizes.
"""


def automata_page(
    literature: Sequence[Row], paper: Sequence[Row], bombs: Sequence[Alone], runs: int
) -> str:
    """The page. `literature` may be empty: then it has no section on that.

    Only the last two sections depend on the machine.
    """
    parts = [HEAD]
    if literature:
        parts += [_sets(literature), _above(literature)]
    return "\n".join([*parts, _paper(paper), _times(literature, paper, runs), _bombs(bombs)])


def _sets(rows: Sequence[Row]) -> str:
    columns = [
        "set",
        "formulas",
        *(variant.replace("_", ", ") for variant in VARIANTS),
        "best of these",
        "**edge**",
        "larger",
        "smaller",
        "with jumps",
        "state",
    ]
    lines = []
    names = list(dict.fromkeys(row.name for row in rows))
    for name in [*names, None]:
        some = [row for row in rows if name in (None, row.name)]
        sizes = [row.reference.sizes for row in some if row.reference is not None]
        lines.append(
            [
                name or "all",
                len(some),
                *(sum(column) for column in zip(*sizes, strict=True)),
                sum(row.best or 0 for row in some),
                f"**{_sum([row.edge for row in some])}**",
                sum(row.is_above for row in some),
                sum(row.is_below for row in some),
                sum(row.edge.jumps > 0 for row in some),
                _sum([row.state for row in some]),
            ]
        )
    text = (
        "## Formulas from the literature\n\n"
        "Formulas of four sets and their negations, beside four published variants. States are\n"
        "summed; *larger* and *smaller* count formulas by the best of the four variants.\n\n"
    )
    return text + table(columns, lines)


def _sum(some: Sequence[Measured]) -> str:
    """The states of all; what ended in an error is counted apart."""
    failed = sum(measured.code is not None for measured in some)
    total = str(sum(measured.states for measured in some))
    return f"{total} and {failed} failed" if failed else total


def _above(rows: Sequence[Row]) -> str:
    above = [row for row in rows if row.is_above]
    if not above:
        return "No formula is larger than the best of the four variants.\n"
    lines = [[f"`{_bars(row.formula)}`", row.best, _size(row.edge)] for row in above]
    return "Larger than the best of the four variants:\n\n" + table(
        ("formula", "best of four", "edge"), lines
    )


def _paper(rows: Sequence[Row]) -> str:
    lines = [
        [
            row.name,
            f"`{_bars(row.formula)}`",
            "–" if row.best is None else row.best,
            _size(row.edge),
            _size(row.state),
            row.edge.jumps,
        ]
        for row in rows
    ]
    columns = ("name", "formula", "best known", "edge", "state", "jumps")
    return "## Formulas of the paper\n\n" + table(columns, lines)


def _times(literature: Sequence[Row], paper: Sequence[Row], runs: int) -> str:
    lines = []
    for name, rows in (("literature", literature), ("paper", paper)):
        if rows:
            figures = Figures.of(row.edge.ms for row in rows)
            numbers = (figures.median, figures.late, figures.longest)
            lines.append([name, len(rows), *(f"{ms:.1f}" for ms in numbers)])
    text = (
        "## Times\n\n"
        "Milliseconds of processor time for one translation with marked edges, in a warm process:\n"
        f"the median of {runs} for each formula. Measured on {machine()}.\n\n"
    )
    return text + table(("formulas", "number", "median", "99 %", "longest"), lines)


def _bombs(bombs: Sequence[Alone]) -> str:
    lines = [
        [
            bomb.name,
            f"`{_bars(bomb.formula)}`",
            _size(bomb.measured),
            f"{bomb.measured.ms / 1000:.1f}",
            f"{bomb.peak:.0f}",
        ]
        for bomb in bombs
    ]
    text = (
        "## Formulas made to explode\n\n"
        f"Each in a process of its own, with the default limits of {LIMITS}: states, or the code\n"
        "of the error, then seconds and the process's memory in MiB.\n\n"
    )
    return text + table(("name", "formula", "state", "s", "MiB"), lines)


def _size(measured: Measured) -> str:
    return str(measured.states) if measured.code is None else measured.code


def _bars(formula: str) -> str:
    """A formula inside a table: a bar would end its cell."""
    return formula.replace("|", "\\|")
