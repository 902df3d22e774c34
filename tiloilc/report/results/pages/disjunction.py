"""Figure 8: a formula with two ways to satisfy it."""

from __future__ import annotations

from tiloilc.report.results.book import Book
from tiloilc.report.results.markdown import MADE
from tiloilc.report.results.pages.learning import READING, sections

TASK = "flatworld_disjunction"


def figure_8(book: Book) -> str:
    """FlatWorld Disjunction: curves and numbers; its trajectories are in no record."""
    text = f"# Figure 8: FlatWorld Disjunction\n\n{MADE}\n"
    text += (
        "First yellow and then green, or first red and then green; never blue. The paper shows\n"
        "curves, and that TiLoIL chooses its way by where it starts while LCER always takes the\n"
        "same.\n\n"
    )
    text += READING + sections(book, [TASK])
    return text + (
        "\nTrajectories are not in records. The report of a run (`tiloilc report RUN`) draws one\n"
        "episode of every seed over the map, from the fixed start; with\n"
        "`environment: {kwargs: {random_start: true}}` in a copy of the task file episodes begin\n"
        "anywhere outside the discs. Runs with random starts are not recorded.\n"
    )
