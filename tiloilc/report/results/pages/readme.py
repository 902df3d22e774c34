"""What the project's README shows of results: one figure, one table, between two markers."""

from __future__ import annotations

from tiloilc.report.results import paper
from tiloilc.report.results.book import Book
from tiloilc.report.results.drawing import picture
from tiloilc.report.results.markdown import NOT_RUN, cell, listed, optimum, small, table, whole
from tiloilc.report.results.methods import BASELINES, COMPARED, method_name
from tiloilc.report.results.pages.index import cloning
from tiloilc.report.results.pages.learning import panel
from tiloilc.report.results.rows import Row
from tiloilc.report.results.tasks import FIGURE_3, title

__all__ = ["BEGIN", "END", "block", "figure", "fill"]

BEGIN, END = "<!-- results: written by `make results` -->", "<!-- /results -->"

SHOWN = ("grid_circular_hard", "flatworld_cycle", "carlo", "fetch_align")
"""A task of each world, of those whose numbers the paper prints."""

PAGE = "docs/results/all.md"


def figure(book: Book) -> str:
    """The learning curves of a few tasks in one drawing; empty if there are none."""
    panels = [found for task in SHOWN if (found := panel(book, task)) is not None]
    return picture(panels, 2, "Learning curves of four tasks") if panels else ""


def block(book: Book) -> str:
    """The figure, the table of figure 3's tasks, and what was run in a sentence."""
    text = "![Learning curves of four tasks, with 95 % intervals](docs/results/overview.svg)\n\n"
    heads = ["task", "TiLoIL", "best baseline", "cloning alone", "paper's best", "optimum"]
    return text + table(heads, [_row(book, task) for task in FIGURE_3]) + f"\n{_told(book)}"


def fill(readme: str, book: Book) -> str:
    """The README's text with the block between its markers.

    Raises ValueError if the markers are not there, once each.
    """
    before, found, rest = readme.partition(BEGIN)
    _, closed, after = rest.partition(END)
    if not found or not closed or BEGIN in rest or END in after:
        raise ValueError(f"the README needs `{BEGIN}` and `{END}`, once each")
    return f"{before}{BEGIN}\n\n{block(book)}\n{END}{after}"


def _row(book: Book, task: str) -> list[str]:
    mine = paper.best(task)
    rival = best_baseline(book, task)
    beside = "" if rival is None else method_name(rival.algorithm)
    return [
        title(task),
        cell(book.usual(task, "tiloil"), page=PAGE),
        NOT_RUN if rival is None else cell(rival, beside, page=PAGE),
        cloning(book, task, page=PAGE),
        "–" if mine is None else whole(mine.text) + small(mine.source),
        optimum(book.optimum(task)),
    ]


def best_baseline(book: Book, task: str) -> Row | None:
    """The row of the baseline with the highest mean."""
    found = [row for name in BASELINES if (row := book.usual(task, name)) is not None]
    return max(found, key=lambda row: float(row.values("greedy").mean()), default=None)


def _told(book: Book) -> str:
    """How many tasks each method was run on, and how many of them in full."""
    said, none = [], []
    for name in COMPARED:
        rows = [row for task in book.tasks if (row := book.usual(task, name)) is not None]
        full = sum(not row.lacks for row in rows)
        if rows:
            said.append(f"{method_name(name)} on {len(rows)} ({full} in full)")
        else:
            none.append(method_name(name))
    text = (
        f"Of {len(book.tasks)} tasks there are runs of {listed(said)}; in full is with ten seeds\n"
    )
    text += "or more and all steps of the task file."
    if none:
        text += f" {listed(none)} were not run." if len(none) > 1 else f" {none[0]} was not run."
    return text + "\n"
