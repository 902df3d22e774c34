"""Sample efficiency over tasks: what share of the optimum methods make as training goes on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tiloilc.evaluate import Band
from tiloilc.report.results.book import Book
from tiloilc.report.results.drawing import Line, Panel, picture
from tiloilc.report.results.measures import mean_of_tasks
from tiloilc.report.results.methods import BASELINES, COMPARED, METHODS, method_name
from tiloilc.report.results.rows import Floats, Row

PATH = "efficiency.svg"

POINTS = tuple(range(5, 101, 5))
"""Where curves are drawn, in hundredths of the training steps of TiLoIL."""

RESAMPLES = 2_000


def shared_tasks(book: Book) -> list[str]:
    """The tasks that TiLoIL and every baseline with any row were run on, of a known optimum."""
    methods = ["tiloil", *(m for m in BASELINES if any(r.algorithm == m for r in book.rows))]
    return [
        task
        for task in book.tasks
        if (best := book.optimum(task)) is not None
        and best[0] > 0
        and all(_judged(book.usual(task, method)) for method in methods)
    ]


def files(book: Book) -> dict[str, str]:
    """The drawing by its path; nothing if there is no task to draw."""
    tasks = shared_tasks(book)
    lines = [one for method in COMPARED if (one := _line(book, method, tasks))]
    if not lines:
        return {}
    count = f"{len(tasks)} task{'' if len(tasks) == 1 else 's'}"
    panel = Panel(
        f"Visits over training, {count}", "share of the optimum: mean over tasks", lines,
        about="% of TiLoIL's training steps",
    )  # fmt: skip
    return {PATH: picture([panel], 1, f"Sample efficiency over {count}")}


def _judged(row: Row | None) -> bool:
    return row is not None and len(row.curve("accepting_visits")[0]) > 0


def _line(book: Book, method: str, tasks: Sequence[str]) -> Line | None:
    """A method's curve over the tasks; None if it was not run on them, or judged only once."""
    curves = []
    for task in tasks:
        row, whole, best = book.usual(task, method), book.usual(task, "tiloil"), book.optimum(task)
        if row is None or whole is None or best is None:
            return None
        steps, values = row.curve("accepting_visits")
        curves.append((np.array(steps) * 100 / whole.steps, values / best[0]))
    if not curves:
        return None
    first = max(at[0] for at, _ in curves)
    last = min(at[-1] for at, _ in curves)
    shown = [point for point in POINTS if first <= point <= max(last, first)]
    if len(shown) < 2:
        return None
    middle, low, high = np.array([_at(curves, point) for point in shown]).T
    name, ink = method_name(method), METHODS[method][1]
    return Line(name, ink, shown, Band(middle, low, high))


def _at(curves: Sequence[tuple[Floats, Floats]], point: int) -> tuple[float, float, float]:
    """The mean and its interval, of the last evaluations before a point."""
    strata = [values[np.searchsorted(at, point, side="right") - 1] for at, values in curves]
    middle, interval = mean_of_tasks(strata, resamples=RESAMPLES)
    return middle, interval.low, interval.high
