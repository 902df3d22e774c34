"""A picture as a list of shapes, in pixels, y downwards: what SVG and PNG have in common."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

Pixels: TypeAlias = npt.NDArray[np.uint8]
Point: TypeAlias = tuple[float, float]

PAPER, CARD, INK, SOFT, LINE = "#ffffff", "#f6f6f3", "#1d1f24", "#666d75", "#d9dbd6"
"""The ground, that of a picture in it, text, lesser text, and thin lines."""


@dataclass(frozen=True, slots=True)
class Look:
    """How a shape is shown: colours are `#rrggbb` or empty, `fill_alpha` and `alpha` in [0, 1]."""

    fill: str = ""
    stroke: str = ""
    width: float = 1.0
    fill_alpha: float = 1.0
    alpha: float = 1.0


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle."""

    x: float
    y: float
    radius: float
    look: Look


@dataclass(frozen=True, slots=True)
class Ring:
    """What lies between two circles about one centre."""

    x: float
    y: float
    inner: float
    outer: float
    look: Look


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle from its upper left corner."""

    x: float
    y: float
    width: float
    height: float
    look: Look


@dataclass(frozen=True, slots=True)
class Path:
    """A line from point to point."""

    points: tuple[Point, ...]
    look: Look


@dataclass(frozen=True, slots=True)
class Text:
    """One line of text; (x, y) is on its baseline, at its beginning, middle or end."""

    x: float
    y: float
    text: str
    size: float
    color: str = INK
    anchor: Literal["start", "middle", "end"] = "start"
    bold: bool = False
    alpha: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Photo:
    """Pixels [h, w, 3] in a rectangle."""

    x: float
    y: float
    width: float
    height: float
    pixels: Pixels


Plain: TypeAlias = Disc | Ring | Box | Path | Text | Photo


@dataclass(frozen=True, slots=True)
class Clip:
    """Shapes of which only what lies in a rectangle is shown."""

    frame: Box
    shapes: tuple[Plain, ...]


Shape: TypeAlias = Plain | Clip


@dataclass(frozen=True)
class Canvas:
    """A picture; `title` says in words what it shows."""

    width: float
    height: float
    title: str
    shapes: tuple[Shape, ...] = field(default=())

    def plus(self, *shapes: Shape) -> Canvas:
        """The same picture with more shapes over it."""
        return replace(self, shapes=(*self.shapes, *shapes))


def width_of(text: str, size: float) -> float:
    """About how wide a line of text is, a little more than any usual sans-serif font needs."""
    narrow = sum(letter in "iljft.,:;|!()[]{}' " for letter in text)
    return size * (0.57 * (len(text) - narrow) + 0.31 * narrow)


def fitted(text: str, size: float, width: float) -> str:
    """The text, cut with … where it would be wider than `width`."""
    if width_of(text, size) <= width:
        return text
    while text and width_of(text + "…", size) > width:
        text = text[:-1]
    return text.rstrip() + "…"
