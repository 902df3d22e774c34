"""Curves over training as an SVG file of its own: it brings its type, ground and both colourings.

What a browser shows follows its reader's light or dark mode; a ground of its own keeps the picture
readable on any page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tiloilc.evaluate import Band
from tiloilc.report.frame import Frame, short, ticks
from tiloilc.report.markup import Markup, number, tag
from tiloilc.report.results.methods import Ink

__all__ = ["Line", "Panel", "picture"]

WIDTH, HEIGHT = 460.0, 300.0
"""Of one panel; two stand beside each other on a page."""

LEGEND_LINE = 20.0
HEAD, FOOT, LEFT, RIGHT = 52.0, 44.0, 46.0, 24.0

MOST_POINTS, OF_ALL = 80, 160
"""Of a curve, and of one method's in all panels; of more every second, third, … and the last are
drawn, so that files stay small."""

STYLE = """\
text{font:12px system-ui,-apple-system,"Segoe UI",Roboto,"Liberation Sans",sans-serif;fill:#555b66}
.t{font-weight:650;font-size:15px;fill:#1d1f24}.y{text-anchor:end}.x{text-anchor:middle}
.ground{fill:#fefefc;stroke:#dcdad3}.grid{stroke:#e9e7e1}.axis{stroke:#8b8f98}
path{fill:none;stroke-linejoin:round;stroke-linecap:round}.band{fill-opacity:.15;stroke:none}
.best{stroke:#1d1f24;stroke-width:1.4;stroke-dasharray:7 4}
"""

DARK = """\
text{fill:#a7abb4}.t{fill:#eceae5}.ground{fill:#16181d;stroke:#3a3e46}.grid{stroke:#2a2e35}
.axis{stroke:#7b808a}.best{stroke:#eceae5}
"""


@dataclass(frozen=True)
class Line:
    """One curve: its mean and interval over seeds at each step."""

    label: str
    ink: Ink
    steps: Sequence[int]
    band: Band


@dataclass(frozen=True)
class Panel:
    """Curves on common axes; `best` is a level to compare with and its name.

    `about` says what goes from left to right.
    """

    title: str
    unit: str
    lines: Sequence[Line]
    best: tuple[str, float] | None = None
    about: str = "environment steps per seed"


def picture(panels: Sequence[Panel], across: int, title: str) -> str:
    """The file: panels in rows of `across`, and one legend of all below."""
    inks = {line.label: line.ink for panel in panels for line in panel.lines}
    level = next((panel.best[0] for panel in panels if panel.best is not None), None)
    keys = [*inks, *([] if level is None else [level])]
    down = -(-len(panels) // across)
    width, plots = WIDTH * min(across, len(panels)), HEIGHT * down
    places, rows = _legend_places(keys, width)
    height = plots + rows * LEGEND_LINE + 12
    names = {label: f"c{i}" for i, label in enumerate(inks)}
    body = [tag("rect", class_="ground", x=0.5, y=0.5, width=width - 1, height=height - 1, rx=8)]
    for i, panel in enumerate(panels):
        at = f"translate({number(i % across * WIDTH)},{number(i // across * HEIGHT)})"
        most = min(MOST_POINTS, OF_ALL // len(panels))
        body.append(tag("g", _panel(panel, names, most), transform=at))
    for key, (x, row) in zip(keys, places, strict=True):
        y = plots + row * LEGEND_LINE + 8
        kind = "best" if key not in names else f"line {names[key]}"
        body.append(tag("path", class_=kind, d=f"M{number(x)},{number(y)}h28"))
        body.append(tag("text", key, x=x + 34, y=y + 4))
    drawn = tag(
        "svg",
        tag("title", title),
        tag("style", Markup(_style(names, inks))),
        body,
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {number(width)} {number(height)}",
        width=width,
        height=height,
        role="img",
        aria_label=title,
    )
    return f"{drawn}\n"


def _panel(panel: Panel, names: dict[str, str], most: int) -> list[Markup]:
    tops = [float(np.nanmax(line.band.high)) for line in panel.lines]
    tops += [] if panel.best is None else [panel.best[1]]
    lows = [float(np.nanmin(line.band.low)) for line in panel.lines]
    marks = ticks(min(0.0, *lows), max(1e-9, *tops), 4)
    last = max(line.steps[-1] for line in panel.lines)
    frame = Frame(WIDTH, HEIGHT, RIGHT, last, marks[0], marks[-1], LEFT, HEAD, FOOT)
    body = [
        tag("text", panel.title, class_="t", x=12, y=22),
        tag("text", panel.unit, x=12, y=38),
    ]
    right, base = WIDTH - RIGHT, HEIGHT - FOOT
    for value in marks:
        y = frame.y(value)
        body.append(tag("path", class_="grid", d=f"M{number(LEFT)},{number(y)}H{number(right)}"))
        body.append(tag("text", number(value), class_="y", x=LEFT - 7, y=y + 4))
    for value in ticks(0, last, 5):
        if value <= last * (1 + 1e-9):
            x = frame.x(value)
            body.append(tag("path", class_="axis", d=f"M{number(x)},{number(base)}v4"))
            body.append(tag("text", short(value), class_="x", x=x, y=base + 17))
    body.append(tag("path", class_="axis", d=f"M{number(LEFT)},{number(base)}H{number(right)}"))
    body.append(tag("text", panel.about, class_="x", x=(LEFT + right) / 2, y=base + 33))
    if panel.best is not None:
        y = frame.y(panel.best[1])
        body.append(tag("path", class_="best", d=f"M{number(LEFT)},{number(y)}H{number(right)}"))
    for kind in ("band", "line"):  # no band over a line
        for line in panel.lines:
            path = _path(frame, line, kind == "band", most)
            body.append(tag("path", class_=f"{kind} {names[line.label]}", d=path))
    return body


def _path(frame: Frame, line: Line, area: bool, most: int) -> str:
    """The mean, or the interval as a closed area; tenths of a point are enough."""
    stride = -(-len(line.steps) // most)
    kept = sorted({*range(0, len(line.steps), stride), len(line.steps) - 1})

    def points(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[str]:
        found = [(frame.x(line.steps[i]), frame.y(float(values[i]))) for i in kept]
        return [f"{x:.1f},{y:.1f}".replace(".0", "") for x, y in found]

    if not area:
        return "M" + "L".join(points(line.band.mean))
    return "M" + "L".join([*points(line.band.high), *reversed(points(line.band.low))]) + "Z"


def _legend_places(keys: Sequence[str], width: float) -> tuple[list[tuple[float, int]], int]:
    """(x, row) of each key, in as many rows as they need, and how many these are."""
    places, x, row = [], 14.0, 0
    for key in keys:
        room = 34 + 7.2 * len(key) + 18
        if x + room > width and x > 14:
            x, row = 14.0, row + 1
        places.append((x, row))
        x += room
    return places, row + 1 if keys else 0


def _style(names: dict[str, str], inks: dict[str, Ink]) -> str:
    """Both colourings of the curves that are there."""

    def colors(dark: bool) -> str:
        rules = []
        for label, name in names.items():
            color = inks[label].dark if dark else inks[label].light
            rules.append(f".line.{name}{{stroke:{color}}}.band.{name}{{fill:{color}}}")
        return "".join(rules)

    shapes = ""
    for label, name in names.items():
        ink = inks[label]
        dash = f";stroke-dasharray:{ink.dash}" if ink.dash else ""
        shapes += f".line.{name}{{stroke-width:{number(ink.width)}{dash}}}"
    dark = f"@media (prefers-color-scheme:dark){{{DARK}{colors(True)}}}"
    return f"{STYLE}{shapes}{colors(False)}\n{dark}"
