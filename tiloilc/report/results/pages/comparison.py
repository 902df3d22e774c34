"""TiLoIL beside each baseline: how likely it is better, and how fast each learns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from tiloilc.diag import counted
from tiloilc.evaluate import (
    generator,
    interquartile_mean,
    probability_of_improvement,
    stratified_bootstrap,
)
from tiloilc.report.results import paper
from tiloilc.report.results.book import Book
from tiloilc.report.results.markdown import (
    MADE,
    between,
    listed,
    optimum,
    pictures,
    spread,
    table,
)  # fmt: skip
from tiloilc.report.results.measures import height, mean_of_tasks, reached
from tiloilc.report.results.methods import BASELINES, method_name
from tiloilc.report.results.pages import efficiency
from tiloilc.report.results.rows import Floats, Row
from tiloilc.report.results.tasks import title

LIKELY = """\
## How likely TiLoIL is better

The probability that a run of TiLoIL makes more accepting visits than a run of the other method, on
a task of those that both were run on, with a 95 % stratified bootstrap interval (Agarwal et al.
2021, *Deep reinforcement learning at the edge of the statistical precipice*). Ties count half, so
0.5 means no difference. The means over tasks, and the interquartile means (IQM) over all runs of
these tasks, are of visits as a share of the optimum, or of the best that is known; an IQM leaves
the worst and the best quarter of runs out.

"""

FAST = """\
## How fast each learns

After how many environment steps of a seed the mean over seeds, in validation, first makes 90 % of
the paper's best number for TiLoIL, and 90 % of the optimum; and the mean height of the curve of
visits over training, which is the area under it by its length. Where methods were trained for
different numbers of steps, heights do not compare.

"""


CURVES = """\
The drawing is of the tasks that TiLoIL and every baseline with records were run on: the mean over
tasks of visits in validation as a share of the optimum, or of the best that is known, with its 95 %
stratified bootstrap interval. A value is that of the last evaluation before it.

"""


def files(book: Book) -> dict[str, str]:
    """The page and its drawing, by their paths."""
    drawn = efficiency.files(book)
    return {"comparison.md": _page(book, list(drawn)), **drawn}


def _page(book: Book, drawn: Sequence[str]) -> str:
    text = f"# Comparison\n\n{MADE}\n" + LIKELY
    beside = {other: _both(book, other) for other in BASELINES}
    overall = [_overall(book, other, both) for other, both in beside.items()]
    heads = ["TiLoIL beside", "tasks", "P(TiLoIL is better) [95 %]", "TiLoIL: mean", "it: mean"]
    heads += ["TiLoIL: IQM", "it: IQM"]
    text += table(heads, overall) + "\n"
    present = {other: both for other, both in beside.items() if both}
    if present:
        heads = ["task", *(method_name(other) for other in present)]
        text += "Task by task:\n\n"
        text += table(heads, [r for task in book.tasks if (r := _likely(task, present.values()))])
        text += "\n"
    absent = [method_name(other) for other in BASELINES if other not in present]
    if absent:
        text += f"Not run on any task: {listed(absent)}.\n\n"
    rows = [row for task in book.tasks for row in _fast(book, task)]
    heads = [
        "task", "method", "steps", "to 90 % of the paper", "to 90 % of the optimum", "mean height",
        "optimum",
    ]  # fmt: skip
    text += FAST
    if drawn:
        text += CURVES + pictures([(path, "Sample efficiency over tasks") for path in drawn]) + "\n"
    return text + table(heads, rows)


Both = Mapping[str, tuple[Row, Row]]
"""The tasks that TiLoIL and another method were run on, with their rows."""


def _both(book: Book, other: str) -> Both:
    found = {task: (book.usual(task, "tiloil"), book.usual(task, other)) for task in book.tasks}
    return {task: (x, y) for task, (x, y) in found.items() if x is not None and y is not None}


def _overall(book: Book, other: str, both: Both) -> list[str]:
    if not both:
        return [method_name(other), "0", "not run", *["–"] * 4]
    pairs = [(x.values("greedy"), y.values("greedy")) for x, y in both.values()]
    likely, interval = probability_of_improvement(pairs, generator())
    shares = [(pair, best[0]) for (task, pair) in zip(both, pairs, strict=True)
              if (best := book.optimum(task)) is not None and best[0] > 0]  # fmt: skip
    cells = ["–"] * 4
    if shares:
        sides = [[pair[side] / best for pair, best in shares] for side in (0, 1)]
        cells = [f(strata) for f in (_mean, _iqm) for strata in sides]
    return [
        method_name(other),
        counted(len(both), "task"),
        f"{likely:.2f} {between(interval)}",
        *cells,
    ]


def _mean(strata: list[Floats]) -> str:
    middle, interval = mean_of_tasks(strata)
    return f"{middle:.2f} {between(interval)}"


def _iqm(strata: list[Floats]) -> str:
    middle = float(interquartile_mean(np.concatenate(strata)))
    return f"{middle:.2f} {between(stratified_bootstrap(strata, interquartile_mean, generator()))}"


def _likely(task: str, others: Iterable[Both]) -> list[str]:
    """One task's probabilities; nothing if no method was run beside TiLoIL."""
    cells = []
    for both in others:
        pair = both.get(task)
        if pair is None:
            cells.append("–")
            continue
        x, y = (row.values("greedy") for row in pair)
        likely, interval = probability_of_improvement([(x, y)], generator())
        cells.append(f"{likely:.2f} {between(interval)}")
    return [title(task), *cells] if any(cell != "–" for cell in cells) else []


def _fast(book: Book, task: str) -> list[list[str]]:
    mine, best = paper.best(task), book.optimum(task)
    rows = []
    for algorithm in book.algorithms:
        row = book.usual(task, algorithm)
        if row is None or not row.curve("accepting_visits")[0]:
            continue
        rows.append(
            [
                title(task),
                f"[{method_name(algorithm)}](all.md#{row.anchor})",
                f"{row.steps:,}",
                reached(row, None if mine is None else mine.mean),
                reached(row, None if best is None else best[0]),
                spread(height(row)),
                optimum(best),
            ]
        )
    return rows
