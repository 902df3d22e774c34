"""A picture as a list of shapes with roles: what SVG and PNG have in common.

Lengths are points, y goes down. A role says what a shape means; LOOKS says how it is shown, by day
and by night. Nothing is told by colour alone: accepting states have two lines, jumps are dashed,
what is lost has the sign ⊥.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from tiloilc.automaton.drawing.picture.layout import Point

Role = Literal[
    "paper",
    "box",
    "accepting",
    "ring",
    "lost",
    "number",
    "name",
    "edge",
    "head",
    "loop",
    "jump",
    "jumphead",
    "away",
    "awayhead",
    "guard",
    "small",
    "jumptext",
    "awaytext",
    "mark",
    "title",
    "stage",
    "rule",
    "key",
]


@dataclass(frozen=True, slots=True)
class Look:
    """How a role is shown. Colours are #rrggbb or none; `night` are stroke and fill in the dark."""

    stroke: str = "none"
    fill: str = "none"
    night: tuple[str, str] = ("none", "none")
    width: float = 1.0
    dash: str = ""
    size: float = 0.0
    """Font size in points; 0 of what is no text."""
    bold: bool = False


INK, NIGHT_INK = "#1f3a57", "#d3e0ee"
PAPER, NIGHT_PAPER = "#ffffff", "#11181f"
GREY, NIGHT_GREY = "#666d75", "#a3adb8"
JUMP, NIGHT_JUMP = "#9a3f0c", "#f2a469"


def _line(day: str, night: str, width: float, dash: str = "") -> Look:
    return Look(stroke=day, night=(night, "none"), width=width, dash=dash)


def _fill(day: str, night: str) -> Look:
    return Look(fill=day, night=("none", night))


def _text(day: str, night: str, size: float, bold: bool = False) -> Look:
    return Look(fill=day, night=("none", night), size=size, bold=bold)


LOOKS: dict[Role, Look] = {
    "paper": _fill(PAPER, NIGHT_PAPER),
    "box": Look(INK, "#f2f6fa", (NIGHT_INK, "#1c2833"), 1.2),
    "accepting": Look(INK, "#dff2e1", (NIGHT_INK, "#1d3d28"), 1.2),
    "ring": _line(INK, NIGHT_INK, 1.2),
    "lost": Look(GREY, "#e9eaec", (NIGHT_GREY, "#2a3037"), 1.0),
    "number": _text(INK, NIGHT_INK, 12.0, bold=True),
    "name": _text(INK, NIGHT_INK, 10.5),
    "edge": _line(INK, NIGHT_INK, 1.1),
    "head": _fill(INK, NIGHT_INK),
    "loop": _line(INK, NIGHT_INK, 0.8),
    "jump": _line(JUMP, NIGHT_JUMP, 1.2, "5 3"),
    "jumphead": _fill(JUMP, NIGHT_JUMP),
    "away": _line(GREY, NIGHT_GREY, 0.9),
    "awayhead": _fill(GREY, NIGHT_GREY),
    "guard": _text(INK, NIGHT_INK, 10.5),
    "small": _text(INK, NIGHT_INK, 9.5),
    "jumptext": _text(JUMP, NIGHT_JUMP, 12.0, bold=True),
    "awaytext": _text(GREY, NIGHT_GREY, 9.5),
    "mark": _fill(INK, NIGHT_INK),
    "title": _text(INK, NIGHT_INK, 12.5, bold=True),
    "stage": _text(GREY, NIGHT_GREY, 10.0),
    "rule": _line("#c9ced4", "#3a444e", 0.7),
    "key": _text(GREY, NIGHT_GREY, 9.5),
}


@dataclass(frozen=True, slots=True)
class Curve:
    """Bézier pieces from end to end: 3n + 1 points."""

    points: tuple[Point, ...]
    role: Role


@dataclass(frozen=True, slots=True)
class Area:
    """A polygon."""

    points: tuple[Point, ...]
    role: Role


@dataclass(frozen=True, slots=True)
class Rectangle:
    """With its upper left corner at (x, y) and corners of `radius`."""

    x: float
    y: float
    width: float
    height: float
    radius: float
    role: Role


@dataclass(frozen=True, slots=True)
class Disc:
    """A filled circle."""

    x: float
    y: float
    radius: float
    role: Role


@dataclass(frozen=True, slots=True)
class Text:
    """One line. (x, y) is the middle of its baseline, or its beginning."""

    x: float
    y: float
    text: str
    role: Role
    middle: bool = True


Shape: TypeAlias = Curve | Area | Rectangle | Disc | Text


@dataclass(frozen=True, slots=True)
class Group:
    """Shapes that are one thing: `of` names it as in `state 3`, `tooltip` tells of it in full."""

    shapes: tuple[Shape, ...]
    of: str = ""
    tooltip: str = ""


@dataclass(frozen=True, slots=True)
class Scene:
    """A picture. `title` and `description` say in words what it shows."""

    width: float
    height: float
    title: str
    description: str
    groups: tuple[Group, ...]
