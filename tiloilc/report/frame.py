"""The axes of a chart: what its edges stand for, round ticks, and how they are written."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tiloilc.report.markup import number

__all__ = ["Frame", "short", "ticks"]


@dataclass(frozen=True)
class Frame:
    """A plot's size, its margins, and what its edges stand for; x begins at 0."""

    width: float
    height: float
    right: float
    x_max: float
    y_min: float
    y_max: float
    left: float = 46
    top: float = 28
    bottom: float = 44

    def x(self, value: float) -> float:
        """Across, from a value."""
        return self.left + value / self.x_max * (self.width - self.left - self.right)

    def y(self, value: float) -> float:
        """Down, from a value."""
        share = (value - self.y_min) / (self.y_max - self.y_min)
        return self.height - self.bottom - share * (self.height - self.top - self.bottom)


def ticks(low: float, high: float, about: int) -> list[float]:
    """About so many round values that span [low, high]; the last is ≥ high."""
    span = high - low if high > low else 1.0
    raw = span / max(about, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(m * power for m in (1, 2, 2.5, 5, 10) if m * power >= raw * (1 - 1e-9))
    first = math.floor(low / step + 1e-9)
    last = math.ceil((low + span) / step - 1e-9)
    return [round(i * step, 12) for i in range(first, last + 1)]


def short(value: float) -> str:
    """A count of steps as a tick shows it: 500, 20k, 1.5M."""
    if abs(value) >= 1e6:
        return f"{number(value / 1e6)}M"
    return f"{number(value / 1e3)}k" if abs(value) >= 1e3 else number(value)
