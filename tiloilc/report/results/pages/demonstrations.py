"""TiLoIL by its demonstrations: how many (figures 6, 7), unsafe ones (table 3), long (table 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from tiloilc.report.results import paper
from tiloilc.report.results.book import Book
from tiloilc.report.results.drawing import Line, Panel, picture
from tiloilc.report.results.markdown import MADE, cell, listed, optimum, pictures, table
from tiloilc.report.results.measures import gap, line
from tiloilc.report.results.methods import Ink, method_name
from tiloilc.report.results.pages.learning import level
from tiloilc.report.results.rows import FRESH, Row
from tiloilc.report.results.tasks import title

SIZES = (
    "carlo", "cheetah_flip", "doggo_avoid", "doggo_navigate", "fetch_avoid", "fetch_align",
)  # fmt: skip
"""The tasks of figure 6's caption, which says how many all demonstrations are."""

LENGTHS = {"carlo": ("100", "200", "400"), "cheetah_flip": ("100", "200", "400")}

UNSAFE = "carlo_unsafe.npz"

SWEEPS = "sweeps/demonstrations_{}.yaml"
"""The campaigns that make these rows, one a task or kind of robot."""


INKS = {
    "5": Ink("#0068b3", "#58aef2", width=2.8),
    "10": Ink("#00875f", "#3ccb9d"),
    "all": Ink("#c77f00", "#f2b13c"),
}
"""A colour for each size; GAIL's curves are dashed."""


def files(book: Book) -> dict[str, str]:
    """The pages of figures 6 and 7 and their drawings, by their paths."""
    made: dict[str, str] = {}
    for number, methods in (("6", ("tiloil",)), ("7", ("tiloil", "gail"))):
        drawn = _panels(book, methods, f"demonstrations/figure-{number}")
        made |= {path: picture([one], 1, one.title) for path, one in drawn.items()}
        made[f"figure-{number}.md"] = _figure(book, number, methods, drawn)
    return made


def _figure(book: Book, number: str, methods: Sequence[str], drawn: Mapping[str, Panel]) -> str:
    names = listed([method_name(method) for method in methods])
    text = f"# Figure {number}: {names} with more demonstrations\n\n{MADE}\n"
    text += (
        f"{names} with 5, 10 and all demonstrations (the paper's *full*), whose number differs by\n"
        "task. The paper shows curves and prints no results. Numbers are accepting visits, with\n"
        "seeds × steps below; curves are eventual returns with 95 % bootstrap intervals.\n\n"
    )
    if drawn:
        text += pictures([(path, panel.title) for path, panel in drawn.items()]) + "\n"
    return text + _sizes(book, methods) + _how("*")


def _panels(book: Book, methods: Sequence[str], folder: str) -> dict[str, Panel]:
    """A panel for each task with more than the usual demonstrations, by its path."""
    drawn = {}
    for task in SIZES:
        lines: list[Line] = []
        more = False
        for method in methods:
            for (size, ink), row in zip(INKS.items(), _by_size(book, task, method), strict=True):
                look = replace(ink, dash="7 3") if method != "tiloil" else ink
                name = f"{method_name(method)}, {size}"
                found = None if row is None else line(row, name, look)
                lines += [] if found is None else [found]
                more = more or (found is not None and size != "5")
        if more:
            best = level(book, task)
            drawn[f"{folder}/{task}.svg"] = Panel(title(task), "eventual return", lines, best)
    return drawn


def _by_size(book: Book, task: str, method: str) -> list[Row | None]:
    """Its rows with 5, 10 and all demonstrations."""
    more = [_with(book, task, method, {"count": n}) for n in ("10", _all(task))]
    return [book.usual(task, method), *more]


def _all(task: str) -> str:
    """How many the paper's full demonstrations are."""
    return f"{paper.numbers()['figure 6', task, 'full'].mean:g}"


def table_3(book: Book) -> str:
    """Carlo with demonstrations that are unsafe or incomplete only."""
    text = f"# Table 3: only unsafe or incomplete demonstrations\n\n{MADE}\n"
    text += (
        "Ours are of a careless driver that crashes or never makes a whole round:\n"
        f"`demonstrations.file: ../tasks/demonstrations/{UNSAFE}`.\n\n"
    )
    usual = book.usual("carlo", "tiloil")
    unsafe = _with(book, "carlo", "tiloil", {"file": f'"{UNSAFE}"'})
    cells = []
    for row, column in ((usual, "original"), (unsafe, "unsafe")):
        cells.append(cell(row, f"paper {paper.numbers()['table 3', 'carlo', column].text}"))
    rows = [[title("carlo"), *cells, gap(usual, unsafe), optimum(book.optimum("carlo"))]]
    heads = ["task", "the usual ones", "unsafe or incomplete", "difference [95 %]", "optimum"]
    return text + table(heads, rows) + _how("carlo")


def table_4(book: Book) -> str:
    """TiLoIL with demonstrations cut after so many steps."""
    text = f"# Table 4: the length of demonstrations\n\n{MADE}\n"
    text += (
        "Each demonstration is cut after 100, 200 or 400 steps (`demonstrations.max_steps`). The\n"
        "usual ones, cut after two accepting visits and not by steps, stand beside them.\n\n"
    )
    rows = []
    for task, lengths in LENGTHS.items():
        cells = [cell(book.usual(task, "tiloil"))]
        for length in lengths:
            row = _with(book, task, "tiloil", {"max_steps": length})
            cells.append(cell(row, f"paper {paper.numbers()['table 4', task, length].text}"))
        rows.append([title(task), *cells, optimum(book.optimum(task))])
    heads = ["task", "usual", "100 steps", "200 steps", "400 steps", "optimum"]
    return text + table(heads, rows) + _how(*LENGTHS)


def _sizes(book: Book, methods: Sequence[str]) -> str:
    rows = []
    missing: dict[str, None] = {}
    for task in SIZES:
        for method in methods:
            found = _by_size(book, task, method)
            shown = [cell(row) for row in found]
            shown[2] = f"{shown[2]} ({_all(task)})"
            rows.append([title(task), method_name(method), *shown, optimum(book.optimum(task))])
            if None in found:
                missing[title(task)] = None
    heads = ["task", "method", "5", "10", "all", "optimum"]
    said = f"\nNot run, in whole or in part: {listed(list(missing))}.\n"
    return table(heads, rows) + (said if missing else "")


def _how(*which: str) -> str:
    """The command that makes the rows of a page."""
    sweeps = " ".join(SWEEPS.format(name) for name in which)
    return (
        "\nThese rows are made, as far as they are not recorded yet, by\n"
        f"`tiloilc sweep {sweeps}`.\n"
        "Others are made by settings like `--set demonstrations.count=20`, of `tiloilc sweep` or\n"
        f"`tiloilc run`, with seeds from {FRESH} on. Records name the demonstrations they are of.\n"
    )


def _with(book: Book, task: str, method: str, changes: dict[str, str]) -> Row | None:
    """The longest row whose demonstrations differ from the task file's in this, and no setting."""
    wanted = {f"demonstrations.{name}": value for name, value in changes.items()}
    aside = {"demonstrations.source", "demonstrations.max_visits"}
    if "max_steps" in changes:
        aside.add("demonstrations.file")  # long ones come from a file of their own
    found = [
        row
        for row in book.of_task(task, method)
        if row.preset == "default"
        and row.changes == book.own(task, method)
        and {k: v for k, v in row.demonstrations if k not in aside or k in wanted} == wanted
    ]
    return max(found, key=lambda row: (row.steps, len(row.runs)), default=None)
