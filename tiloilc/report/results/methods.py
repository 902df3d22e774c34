"""The methods that are compared: their names, their order and how their curves look, once."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["BASELINES", "COMPARED", "METHODS", "Ink", "method_name"]


@dataclass(frozen=True)
class Ink:
    """A curve's colour on a light and on a dark ground, its dashes and its width."""

    light: str
    dark: str
    dash: str = ""
    width: float = 2.0


METHODS: dict[str, tuple[str, Ink]] = {
    "tiloil": ("TiLoIL", Ink("#0068b3", "#58aef2", width=2.8)),
    "lcer": ("LCER", Ink("#c77f00", "#f2b13c")),
    "cycler": ("CyclER", Ink("#00875f", "#3ccb9d")),
    "drl2": ("DRL²", Ink("#cf4f00", "#ff8a4c")),
    "gail": ("GAIL", Ink("#ad4f86", "#eb9fcd", "7 3")),
    "pwil": ("PWIL", Ink("#2a93cf", "#93d6fb", "7 3")),
    "sqil": ("SQIL", Ink("#857a00", "#e0d552", "7 3")),
    "cloning": ("cloning alone", Ink("#666666", "#b0b0b0", "1.5 3.5")),
}
"""After Okabe and Ito's colours, which most colour-blind readers tell apart, darkened or lightened
for their ground. Methods of reinforcement learning are drawn through, those of imitation dashed."""

BASELINES = ("lcer", "cycler", "drl2", "gail", "pwil", "sqil")
"""The methods that the paper compares with."""

COMPARED = ("tiloil", *BASELINES)
"""All of its tables, in their order."""


def method_name(algorithm: str) -> str:
    """As people write it; an algorithm of a package's own keeps its name."""
    known = METHODS.get(algorithm)
    return algorithm if known is None else known[0]
