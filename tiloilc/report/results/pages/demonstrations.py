"""TiLoIL by its demonstrations: how many (figures 6, 7), unsafe ones (table 3), long (table 4)."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.report.results import paper
from tiloilc.report.results.book import Book
from tiloilc.report.results.markdown import MADE, cell, listed, optimum, table
from tiloilc.report.results.measures import gap
from tiloilc.report.results.methods import method_name
from tiloilc.report.results.rows import FRESH, Row
from tiloilc.report.results.tasks import title

SIZES = (
    "carlo", "cheetah_flip", "doggo_avoid", "doggo_navigate", "fetch_avoid", "fetch_align",
)  # fmt: skip
"""The tasks of figure 6's caption, which says how many all demonstrations are."""

LENGTHS = {"carlo": ("100", "200", "400"), "cheetah_flip": ("100", "200", "400")}

UNSAFE = "carlo_unsafe.npz"

HOW = f"""
To make such a row, copy the task file to another folder, keep its `name`, change its
`demonstrations` there, and run the copy: `tiloilc run COPY --set first_seed={FRESH} --record
results/TASK.jsonl.gz`. Records name the demonstrations they are of.
"""


def figure_6(book: Book) -> str:
    """TiLoIL with more demonstrations."""
    text = f"# Figure 6: more demonstrations\n\n{MADE}\n"
    text += (
        "TiLoIL with 5, 10 and what the paper calls all demonstrations, whose number differs by\n"
        "task. The paper shows curves and prints no results. Numbers are accepting visits.\n\n"
    )
    return text + _sizes(book, ("tiloil",)) + HOW.replace("`demonstrations`", "`count`")


def figure_7(book: Book) -> str:
    """TiLoIL and GAIL with more demonstrations."""
    text = f"# Figure 7: TiLoIL and GAIL with more demonstrations\n\n{MADE}\n"
    text += (
        "The paper shows curves of both with 5, 10 and all demonstrations and prints no results.\n"
        "Numbers are accepting visits.\n\n"
    )
    return text + _sizes(book, ("tiloil", "gail")) + HOW.replace("`demonstrations`", "`count`")


def table_3(book: Book) -> str:
    """Carlo with demonstrations that are unsafe or incomplete only."""
    text = f"# Table 3: only unsafe or incomplete demonstrations\n\n{MADE}\n"
    text += (
        "Ours are of a careless driver that crashes or never makes a whole round:\n"
        f"`demonstrations: {{file: ../tasks/demonstrations/{UNSAFE}}}` in the task file.\n\n"
    )
    usual = book.usual("carlo", "tiloil")
    unsafe = _with(book, "carlo", "tiloil", {"file": f'"{UNSAFE}"'})
    cells = []
    for row, column in ((usual, "original"), (unsafe, "unsafe")):
        cells.append(cell(row, f"paper {paper.numbers()['table 3', 'carlo', column].text}"))
    rows = [[title("carlo"), *cells, gap(usual, unsafe), optimum(book.optimum("carlo"))]]
    heads = ["task", "the usual ones", "unsafe or incomplete", "difference [95 %]", "optimum"]
    return text + table(heads, rows) + HOW


def table_4(book: Book) -> str:
    """TiLoIL with demonstrations cut after so many steps."""
    text = f"# Table 4: the length of demonstrations\n\n{MADE}\n"
    text += (
        "Each demonstration is cut after 100, 200 or 400 steps (`max_steps`). The usual ones, cut\n"
        "after two accepting visits and not by steps, stand beside them.\n\n"
    )
    rows = []
    for task, lengths in LENGTHS.items():
        cells = [cell(book.usual(task, "tiloil"))]
        for length in lengths:
            row = _with(book, task, "tiloil", {"max_steps": length})
            cells.append(cell(row, f"paper {paper.numbers()['table 4', task, length].text}"))
        rows.append([title(task), *cells, optimum(book.optimum(task))])
    heads = ["task", "usual", "100 steps", "200 steps", "400 steps", "optimum"]
    return text + table(heads, rows) + HOW


def _sizes(book: Book, methods: Sequence[str]) -> str:
    rows = []
    for task in SIZES:
        whole = f"{paper.numbers()['figure 6', task, 'full'].mean:g}"
        for method in methods:
            found = [book.usual(task, method)]
            found += [_with(book, task, method, {"count": n}) for n in ("10", whole)]
            shown = [cell(row) for row in found]
            shown[2] = f"{shown[2]} ({whole})"
            rows.append([title(task), method_name(method), *shown, optimum(book.optimum(task))])
    missing = [row[0] for row in rows if "not run" in " ".join(row)]
    heads = ["task", "method", "5", "10", "all", "optimum"]
    said = f"\nNot run, in whole or in part: {listed(list(dict.fromkeys(missing)))}.\n"
    return table(heads, rows) + (said if missing else "")


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
        and row.changes in book.defaults(task, method)
        and {k: v for k, v in row.demonstrations if k not in aside or k in wanted} == wanted
    ]
    return max(found, key=lambda row: (row.steps, len(row.runs)), default=None)
