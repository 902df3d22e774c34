"""Pieces of Markdown: tables, numbers with their spread, links to the records behind them."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.evaluate import Interval
from tiloilc.report.frame import short
from tiloilc.report.results.rows import Floats, Row

__all__ = [
    "MADE", "NOT_RUN", "between", "cell", "listed", "optimum", "pictures", "seeds",
    "small", "spread", "table", "whole",
]  # fmt: skip

MADE = "Written by `make results` from the records in [`results/`](../../results), not by hand.\n"

NOT_RUN = "not run"


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table with a line of heads."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def spread(values: Floats) -> str:
    """Mean ± standard deviation over seeds; a dash if there is no value."""
    if not len(values):
        return "–"
    sd = values.std(ddof=1) if len(values) > 1 else 0.0
    return f"{values.mean():.2f} ± {sd:.2f}"


def between(interval: Interval) -> str:
    """Both ends of an interval."""
    return f"[{interval.low:.2f}, {interval.high:.2f}]"


def small(*said: str) -> str:
    """More lines in a cell, in small type; nothing if nothing is said."""
    words = "<br>".join(whole(one) for one in said if one)
    return f"<br><sub>{words}</sub>" if words else ""


def whole(text: str) -> str:
    """Text that a narrow column does not break."""
    return text.replace(" ", "\u00a0")


def cell(row: Row | None, *beside: str, strong: bool = False, page: str = "all.md") -> str:
    """A row's visits as a link to the row; below them its seeds and steps, and what is beside."""
    if row is None:
        return NOT_RUN + small(*beside)
    shown = whole(spread(row.values("greedy")))
    shown = f"**{shown}**" if strong else shown
    run = f"{len(row.runs)} × {short(row.steps)}"
    if row.short and row.asked is not None:
        run += f" of {short(row.asked)}"
    return f"[{shown}]({page}#{row.anchor})" + small(run, *beside)


def optimum(best: tuple[float, bool] | None) -> str:
    """The most visits that are possible, or a lower bound of them."""
    return "–" if best is None else f"{'' if best[1] else '≥ '}{best[0]:g}"


def seeds(numbers: Sequence[int]) -> str:
    """Seeds as ranges: 0–9, or 0–4, 7."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]}–{r[-1]}" for r in runs)


def listed(names: Sequence[str]) -> str:
    """a, b and c."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def pictures(paths: Sequence[tuple[str, str]]) -> str:
    """Images with what they show, two beside each other where there is room."""
    images = [f'<img src="{path}" alt="{said}" width="49%">' for path, said in paths]
    return "\n".join(images) + "\n" if images else ""
