"""What a benchmark finds: a value, what it is measured against, and the goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median, quantiles


@dataclass(frozen=True, slots=True)
class Spread:
    """The median of several measurements and the quartiles around it."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """The spread of one or more values."""
        if len(values) == 1:
            return cls(values[0], values[0], values[0])
        low, _, high = quantiles(values, n=4, method="inclusive")
        return cls(median(values), low, high)


@dataclass(frozen=True, slots=True)
class Measurement:
    """One row of the table.

    `goal` is the least `ratio` wanted where there is something to measure `against`, else the most
    that `value` may be; a value that there should be and is not is missed, too. `ratio` is missing
    where `against` is not installed.
    """

    name: str
    value: Spread | None
    unit: str
    against: str | None = None
    theirs: Spread | None = None
    ratio: Spread | None = None
    goal: float | None = None

    @property
    def missed(self) -> bool:
        """Whether there is a goal that what was measured does not reach."""
        if self.goal is None:
            return False
        if self.against is None:
            return self.value is None or self.value.median > self.goal
        return self.ratio is not None and self.ratio.median < self.goal

    def to_json(self) -> dict[str, object]:
        """The row as `bench --json` prints it: medians."""
        return {
            "name": self.name,
            "value": None if self.value is None else self.value.median,
            "unit": self.unit,
            "against": self.against,
            "ratio": None if self.ratio is None else self.ratio.median,
            "goal": self.goal,
        }
