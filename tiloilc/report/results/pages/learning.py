"""Learning curves of the methods, a section a task: figure 3, the grids of figure 5, the robots."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.report.results import paper
from tiloilc.report.results.book import Book
from tiloilc.report.results.drawing import Panel, picture
from tiloilc.report.results.markdown import (
    MADE,
    cell,
    listed,
    optimum,
    pictures,
    spread,
    table,
)  # fmt: skip
from tiloilc.report.results.measures import height, line, most_return, reached
from tiloilc.report.results.methods import COMPARED, METHODS, Ink, method_name
from tiloilc.report.results.rows import FRESH
from tiloilc.report.results.tasks import FIGURE_3, GRIDS, ROBOTS, title

OTHER = Ink("#444444", "#cccccc")
"""The curve of a method that the paper does not have."""

READING = """\
Curves are eventual returns (Eq. 17 and 18, γ = 0.99) of greedy policies on validation episodes: the
mean over seeds, with its 95 % bootstrap interval where the paper shades the standard deviation. The
dashed level is the return of the most visits that are possible, or of the best that is known, which
a curve can pass. In the tables *visits*, with seeds × steps below, are accepting visits of an
episode, not discounted, of each seed's best policy on fresh episodes; the paper's tables print such
counts, too. The two columns on 90 % say after how many steps the mean over seeds first gets there,
of the paper's best number for TiLoIL and of the optimum; *mean height* is the area under the curve
of visits over the steps. Of long curves every second, third, … point is drawn.

"""

COLUMNS = (
    "method", "visits", "paper", "eventual return", "violations", "to 90 % of the paper",
    "to 90 % of the optimum", "mean height",
)  # fmt: skip


def figure_3(book: Book) -> str:
    """TiLoIL and the baselines over training, on the tasks of the paper's figure 3."""
    head = f"# Figure 3: TiLoIL and the baselines over training\n\n{MADE}\n{READING}"
    return head + sections(book, (*FIGURE_3, "sixteen_rooms_prose"))


def grids(book: Book) -> str:
    """The nine grids of figure 5, by tabular Q-learning."""
    head = f"# Figure 5: nine grids by tabular Q-learning\n\n{MADE}\n"
    head += (
        "Three kinds of task in three sizes each: down a corridor without leaving it, through\n"
        "squares in a row, round a cross of squares for ever. The paper prints numbers for the\n"
        "last of the nine only (table 1).\n\n"
    )
    return head + READING + sections(book, GRIDS)


def robots(book: Book) -> str:
    """The tasks on MuJoCo."""
    head = f"# The robots\n\n{MADE}\n"
    head += "Doggo, the Fetch arm and the half cheetah, on MuJoCo.\n\n"
    return head + READING + sections(book, ROBOTS)


def curves(book: Book) -> dict[str, str]:
    """The drawings of all tasks that have a curve, by their paths."""
    drawn = {task: panel(book, task) for task in book.tasks}
    return {
        f"curves/{task}.svg": picture([one], 1, f"Learning curves of {one.title}")
        for task, one in drawn.items()
        if one is not None
    }


def panel(book: Book, task: str) -> Panel | None:
    """The learning curves of one task; None if there is none."""
    lines = []
    for algorithm in book.algorithms:
        row = book.usual(task, algorithm)
        ink = METHODS[algorithm][1] if algorithm in METHODS else OTHER
        drawn = None if row is None else line(row, method_name(algorithm), ink)
        lines += [] if drawn is None else [drawn]
    if not lines:
        return None
    return Panel(title(task), "eventual return", lines, level(book, task))


def level(book: Book, task: str) -> tuple[str, float] | None:
    """What a task's curves are compared with, and its name; None where no optimum is known."""
    best = book.optimum(task)
    return None if best is None else ("optimum, or the best known", most_return(best[0]))


def sections(book: Book, tasks: Sequence[str]) -> str:
    """All curves, then a section for each task."""
    drawn = [task for task in tasks if _drawn(book, task)]
    shown = [(f"curves/{task}.svg", f"Learning curves of {title(task)}") for task in drawn]
    gallery = pictures(shown) + "\n" if shown else ""
    return gallery + "\n".join(section(book, task) for task in tasks)


def section(book: Book, task: str) -> str:
    """One task: every method's numbers beside the paper's, and what is missing."""
    text = f"## {title(task)}\n\n"
    mine, best = paper.best(task), book.optimum(task)
    goals = (None if mine is None else mine.mean, None if best is None else best[0])
    rows = [_row(book, task, name, *goals) for name in _shown(book, task)]
    text += f"Optimum: {optimum(best)}"
    if mine is not None:
        text += f"; the paper's best for TiLoIL: {mine.text} ({mine.source})"
    text += ".\n\n" + table(COLUMNS, rows)
    return text + _missing(book, task)


def _drawn(book: Book, task: str) -> bool:
    """Whether there is a curve, without drawing it."""
    rows = [row for name in book.algorithms if (row := book.usual(task, name)) is not None]
    return any(len(row.curve("eventual_return")[0]) > 1 for row in rows)


def _shown(book: Book, task: str) -> list[str]:
    """Methods with a row or a number of the paper."""
    return [
        name
        for name in book.algorithms
        if book.usual(task, name) is not None or paper.of_algorithm(task, name) is not None
    ]


def _row(
    book: Book, task: str, algorithm: str, papers: float | None, best: float | None
) -> list[str]:
    row, printed = book.usual(task, algorithm), paper.of_algorithm(task, algorithm)
    said = "–" if printed is None else printed.text
    if row is None:
        return [method_name(algorithm), cell(None), said, *["–"] * 5]
    return [
        method_name(algorithm),
        cell(row),
        said,
        spread(row.values("greedy", "eventual_return")),
        f"{row.values('greedy', 'violation_rate').mean():.1%}",
        reached(row, papers),
        reached(row, best),
        spread(height(row)),
    ]


def _missing(book: Book, task: str) -> str:
    """Which methods have no row and how to make one; what was shorter than it should be."""
    said = []
    rows = {n: book.usual(task, n) for n in COMPARED}
    less = [
        f"{method_name(name)} ({lacks})"
        for name, row in rows.items()
        if row is not None and (lacks := row.lacks)
    ]
    if less:
        said.append(f"Fewer steps than the task file's, or fewer than ten seeds: {listed(less)}.")
    absent = [name for name, row in rows.items() if row is None]
    if absent:
        names = listed([method_name(name) for name in absent])
        said.append(f"Not run: {names}. `{command(task, 'algorithm=' + absent[0])}`")
    return f"\n{' '.join(said)}\n" if said else ""


def command(task: str, *changes: str) -> str:
    """How a row is made: a run of the task with some changes on fresh seeds, recorded."""
    sets = "".join(f" --set {change}" for change in (*changes, f"first_seed={FRESH}"))
    return f"tiloilc run specs/{task}.yaml{sets} --record results/{task}.jsonl.gz"
