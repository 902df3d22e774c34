"""The paper's own numbers, from `paper.csv`: what its tables print, once and nowhere else.

The paper calls them eventual discounted returns. They are counts: with γ = 0.99 no return exceeds
100, and 50 steps make 39.5 at most (Eq. 17), yet 360 and 47 are printed. They stand beside our
`accepting_visits`.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from types import MappingProxyType

__all__ = ["Printed", "best", "numbers", "of_algorithm"]

TILOIL = ("beta=0.49", "beta=1/3", "beta=1/4", "separate", "shared")
"""The columns of tables 1 and 2 that are TiLoIL's, with the five usual demonstrations."""


@dataclass(frozen=True)
class Printed:
    """One number of the paper with its spread, nan where none is printed, and where it stands."""

    source: str
    task: str
    column: str
    mean: float
    sd: float

    @property
    def text(self) -> str:
        """As the paper prints it."""
        return f"{self.mean:g}" if self.sd != self.sd else f"{self.mean:g} ± {self.sd:g}"


@cache
def numbers() -> Mapping[tuple[str, str, str], Printed]:
    """All numbers by source (`table 1`), task and column."""
    text = files("tiloilc.report.results").joinpath("paper.csv").read_text(encoding="utf-8")
    found = [
        Printed(
            row["source"], row["task"], row["column"],
            float(row["mean"]), float(row["sd"] or "nan"),
        )
        for row in csv.DictReader(text.splitlines())
    ]  # fmt: skip
    return MappingProxyType({(one.source, one.task, one.column): one for one in found})


def best(task: str) -> Printed | None:
    """The highest number that the paper prints for TiLoIL on a task, the earlier of equals."""
    mine = [
        one for (_, name, column), one in numbers().items() if name == task and column in TILOIL
    ]
    return max(mine, key=lambda one: one.mean, default=None)


def of_algorithm(task: str, algorithm: str) -> Printed | None:
    """What table 1 prints for a method; for TiLoIL that with β = 1/3, which the paper goes by."""
    column = "beta=1/3" if algorithm == "tiloil" else algorithm
    return numbers().get(("table 1", task, column))
