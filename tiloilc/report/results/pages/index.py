"""`README.md` of the results: every task by every method, and what was run and what was not."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.evaluate import difference, generator
from tiloilc.report.results import paper
from tiloilc.report.results.book import Book
from tiloilc.report.results.markdown import (
    MADE,
    NOT_RUN,
    cell,
    listed,
    optimum,
    small,
    spread,
    table,
    whole,
)  # fmt: skip
from tiloilc.report.results.methods import COMPARED, METHODS, method_name
from tiloilc.report.results.pages.learning import command
from tiloilc.report.results.rows import Row
from tiloilc.report.results.tasks import title

METRIC = """\
Numbers are *accepting visits*: steps of an episode at which the automaton's state accepts, not
discounted; mean ± standard deviation over seeds of each seed's best policy by validation episodes,
with greedy actions on fresh episodes. The paper calls what its tables print eventual discounted
returns, but 47 of 50 and 360 of 500 steps are counts: by Eq. 17 with γ = 0.99 no such return
exceeds 39.5 and 99.3. So the paper's numbers stand beside our visits. Our eventual returns by Eq.
17 are on the pages of curves.

"""

BOLD = """\
Where several methods were run, bold is the highest mean of a task and all that are not below it by
more than chance (a 95 % bootstrap interval of the difference that keeps clear of 0). A number leads
to its records; below it stand seeds × steps of each. *Cloning alone* is the policy that TiLoIL
began with. An optimum with ≥ is a lower bound, reached by real actions. The paper's number for
TiLoIL is that with β = 1/3, and its best the highest of [table 1](table-1.md) and
[table 2](table-2.md).

"""

PAGES = {
    "figure-3.md": "figure 3, TiLoIL and the baselines over training",
    "figure-4.md": "figure 4, without segments and without stages",
    "grids.md": "figure 5, the nine grids",
    "figure-6.md": "figure 6, more demonstrations",
    "figure-7.md": "figure 7, TiLoIL and GAIL with more demonstrations",
    "figure-8.md": "figure 8, FlatWorld Disjunction",
    "table-1.md": "table 1, β",
    "table-2.md": "table 2, one discriminator for all stages",
    "table-3.md": "table 3, unsafe or incomplete demonstrations",
    "table-4.md": "table 4, the length of demonstrations",
    "robots.md": "the robots",
    "verified.md": "how likely policies satisfy their formulas for ever",
    "comparison.md": "how likely TiLoIL is better, and how fast each method learns",
    "all.md": "every row, with its settings, seeds, commits and records",
}


def index(book: Book) -> str:
    """The page."""
    text = f"# Results\n\n{MADE}\n{METRIC}"
    text += "".join(f"- [{page}]({page}): {said}\n" for page, said in PAGES.items())
    text += f"\n## Every task by every method\n\n{BOLD}" + overview(book, book.tasks)
    letter = [task for task in book.tasks if any(_letter(book, task))]
    if letter:
        text += "\n## With the paper's table 5 (`preset=paper`)\n\n"
        text += "What a row's runs set otherwise, or left as the task file has it, is on "
        text += "[all.md](all.md).\n\n"
        text += overview(book, letter, "paper")
    return text + "\n## What was run\n\n" + _told(book)


def overview(book: Book, tasks: Sequence[str], preset: str = "default") -> str:
    """A row a task, a column a method."""
    shown = list(COMPARED)
    shown += [n for n in book.algorithms if n not in METHODS]
    before = ["task", "optimum", "paper's best", "cloning alone"]
    heads = [*before, *(method_name(n) for n in shown)]
    rows = []
    for task in tasks:
        found = {n: row for n in shown if (row := book.usual(task, n, preset)) is not None}
        top = best_of(list(found.values()))
        mine = paper.best(task)
        cells = [
            title(task),
            optimum(book.optimum(task)),
            "–" if mine is None else whole(mine.text) + small(mine.source),
            cloning(book, task, preset),
        ]
        for name in shown:
            printed = paper.of_algorithm(task, name)
            beside = "" if printed is None else f"paper {printed.text}"
            row = found.get(name)
            cells.append(cell(row, beside, strong=row in top))
        rows.append(cells)
    return table(heads, rows)


def best_of(rows: Sequence[Row]) -> list[Row]:
    """The row of the highest mean and those not below it by more than chance; none of one alone."""
    if len(rows) < 2:
        return []
    first = max(rows, key=lambda row: float(row.values("greedy").mean()))
    best = first.values("greedy")
    return [
        row
        for row in rows
        if row is first or difference(row.values("greedy"), best, generator())[1].low <= 0
    ]


def cloning(book: Book, task: str, preset: str = "default", page: str = "all.md") -> str:
    """Runs of cloning alone, or else what TiLoIL began with; `page` has the rows' anchors."""
    row = book.usual(task, "cloning", preset)
    if row is not None:
        return cell(row, page=page)
    row = book.usual(task, "tiloil", preset)
    begun = None if row is None else row.values("cloning")
    if row is None or begun is None or not len(begun):
        return "–"
    return f"[{whole(spread(begun))}]({page}#{row.anchor})"


def _letter(book: Book, task: str) -> list[Row]:
    return [row for row in book.of_task(task) if row.preset == "paper"]


def _told(book: Book) -> str:
    """A line a method: on which tasks it ran in full, shorter, with other settings, or not."""
    lines = []
    for algorithm in COMPARED:
        full: list[str] = []
        less: list[str] = []
        other: list[str] = []
        none: list[str] = []
        for task in book.tasks:
            row = book.usual(task, algorithm)
            if row is not None:
                lacks = row.lacks
                (less if lacks else full).append(f"{title(task)} ({lacks})" if lacks else task)
            elif book.of_task(task, algorithm):
                other.append(f"[{title(task)}](all.md)")
            else:
                none.append(task)
        said = []
        if full:
            said.append(f"in full on {_some(book, full)}")
        if less:
            said.append(f"shorter or with fewer seeds on {listed(less)}")
        if other:
            said.append(f"with other settings than the task file's only on {listed(other)}")
        if none:
            said.append(f"{NOT_RUN} on {_some(book, none, 'any task')}")
        lines.append(f"- **{method_name(algorithm)}**: {'; '.join(said)}.\n")
    asked = (
        "In full means ten seeds or more and at least the steps of the task file. A method is run\n"
        "on a task, and its records are added, by (for example)\n"
        f"`{command('flatworld_cycle', 'algorithm=lcer')}`;\n"
        "`make results` then writes these pages. `tiloilc sweep sweeps/FILE.yaml` runs a whole\n"
        "campaign and skips what is recorded.\n"
    )
    return "".join(lines) + "\n" + asked


def _some(book: Book, tasks: Sequence[str], every: str = "every task") -> str:
    """Titles of tasks; all of them in one word, and of most which are left out."""
    left = [title(task) for task in book.tasks if task not in tasks]
    if not left:
        return every
    if len(left) < 5 and len(tasks) > 2 * len(left):
        return f"every task but {listed(left)}"
    return listed([title(task) for task in tasks])
