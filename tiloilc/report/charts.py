"""Hand-written SVG charts: curves with intervals, stacked areas, dot strips.

Colours and type come from the page's style sheet, so that one drawing serves screen and paper.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tiloilc.evaluate import Band, Summary
from tiloilc.report.frame import Frame, short, ticks
from tiloilc.report.markup import Markup, number, tag
from tiloilc.report.runs.reading import Floats

__all__ = ["Area", "Level", "Series", "area_chart", "line_chart", "strip"]

Text = Callable[[float], str]

LEAST_NAMED = 0.05
"""A layer of a smaller share has no room for its name."""


@dataclass(frozen=True)
class Series:
    """A curve: its mean and interval over seeds [points], and each seed's own [points, S]."""

    label: str
    style: str
    steps: tuple[int, ...]
    band: Band
    seeds: Floats
    seed_names: tuple[str, ...]


@dataclass(frozen=True)
class Level:
    """A horizontal line to compare with; `style` is its class."""

    label: str
    style: str
    value: float


@dataclass(frozen=True)
class Area:
    """One layer of a stack: its share at each step [points] and its colour."""

    label: str
    name: str
    color: str
    shares: Floats


def line_chart(
    series: Sequence[Series],
    levels: Sequence[Level] = (),
    *,
    title: str,
    unit: str,
    width: float,
    height: float,
    show: Text = number,
    top: float | None = None,
    bottom: float | None = 0.0,
    labels: bool = True,
) -> Markup:
    """Curves over environment steps with 95 % bands, thin single seeds and levels.

    The y axis runs from `bottom` (None: the least value) to at least `top`. `labels` names the
    levels beside their lines, for charts wide enough to have room there.
    """
    known = [s.seeds[~np.isnan(s.seeds)] for s in series]
    values = np.concatenate([*known, [level.value for level in levels]])
    least = float(values.min(initial=np.inf)) if bottom is None else bottom
    most = max(float(values.max(initial=-np.inf)), top if top is not None else -np.inf)
    if not math.isfinite(least + most):
        least, most = 0.0, 1.0
    y_ticks = ticks(least, most, 4 if height < 240 else 5)
    x_last = max((s.steps[-1] for s in series if s.steps), default=1)
    right = 128 if labels and levels else 16
    frame = Frame(width, height, right, max(x_last, 1), y_ticks[0], y_ticks[-1])
    body = [_axes(frame, y_ticks, show, unit)]
    body += [_level(frame, level) for level in levels]
    for one in series:
        crowded = " crowded" if len(series) > 1 else ""
        body.append(tag("g", _series(frame, one, show), class_=f"series {one.style}{crowded}"))
    if labels:
        body += _level_names(frame, levels, show)
    body.append(tag("line", class_="cursor", y1=frame.top, y2=height - frame.bottom))
    return _svg(frame, body, title, _hover(frame, series, show))


def area_chart(
    steps: Sequence[int], areas: Sequence[Area], *, title: str, width: float, height: float
) -> Markup:
    """Shares of one over environment steps, stacked from the bottom in the order given."""
    frame = Frame(width, height, 34, max(steps[-1], 1), 0.0, 1.0)
    at = [0, *steps]  # the first line of the log speaks of the time since step 0
    base = np.zeros(len(at))
    body = []
    for area in areas:
        over = base + np.concatenate([area.shares[:1], area.shares])
        upper = _points(frame, at, over)
        lower = list(reversed(_points(frame, at, base)))
        body.append(
            tag("path", tag("title", area.label), d=f"{_path(upper + lower)}Z", fill=area.color)
        )
        if area.shares[-1] > LEAST_NAMED:
            middle = frame.y(float((base + over)[-1]) / 2) + 4
            body.append(tag("text", area.name, class_="area-name", x=width - 28, y=middle))
        base = over
    marks = [0.0, 0.25, 0.5, 0.75, 1.0]
    body.append(_axes(frame, marks, lambda v: f"{v * 100:.0f} %", "share of training steps"))
    body.append(tag("line", class_="cursor", y1=frame.top, y2=height - frame.bottom))
    hover = [
        [
            round(frame.x(step), 1),
            f"step {step:,}",
            [f"{area.label}: {area.shares[i] * 100:.1f} %" for area in reversed(areas)],
        ]
        for i, step in enumerate(steps)
    ]
    return _svg(frame, [tag("g", body, class_="areas")], title, hover)


def strip(
    values: Floats, names: Sequence[str], summary: Summary, low: float, high: float, show: Text
) -> Markup:
    """Every seed a dot on the line from `low` to `high`, equal ones stacked, with the IQM's bar."""
    width, height, margin = 132.0, 34.0, 6.0
    span = high - low if high > low else 1.0

    def x(value: float) -> float:
        return margin + (value - low) / span * (width - 2 * margin)

    middle, mark = height / 2, x(summary.iqm)
    interval = summary.iqm_interval
    body = [
        tag("line", class_="rail", x1=margin, x2=width - margin, y1=middle, y2=middle),
        tag("line", class_="ci", x1=x(interval.low), x2=x(interval.high), y1=middle, y2=middle),
        tag("line", class_="iqm", x1=mark, x2=mark, y1=middle - 14, y2=middle + 14),
    ]
    seen = [int(i) for i in np.argsort(values, kind="stable") if not np.isnan(values[i])]
    columns = [round(x(float(values[i])) / 5) for i in seen]
    gap = min(5.2, (height - 6) / max(1, *(columns.count(c) - 1 for c in columns)))
    for place, i in enumerate(seen):
        above, of = columns[:place].count(columns[place]), columns.count(columns[place])
        dot = {"cx": x(float(values[i])), "cy": middle + (above - (of - 1) / 2) * gap}
        about = tag("title", f"{names[i]}: {show(float(values[i]))}")
        body.append(tag("circle", about, class_="dot", r=2.6, **dot))
    return tag("svg", body, class_="strip", viewBox=f"0 0 {number(width)} {number(height)}",
               width=width, height=height, role="img", aria_label="one dot a seed")  # fmt: skip


def _svg(frame: Frame, body: list[Markup], title: str, hover: list[list[object]]) -> Markup:
    return tag(
        "svg",
        tag("title", title),
        body,
        class_="chart",
        viewBox=f"0 0 {number(frame.width)} {number(frame.height)}",
        width=frame.width,
        height=frame.height,
        role="img",
        aria_label=title,
        data_hover=json.dumps(hover, ensure_ascii=False, separators=(",", ":")),
    )


def _axes(frame: Frame, y_ticks: Sequence[float], show: Text, unit: str) -> Markup:
    right, base = frame.width - frame.right, frame.height - frame.bottom
    body = []
    for value in y_ticks:
        y = frame.y(value)
        body.append(tag("line", class_="grid", x1=frame.left, x2=right, y1=y, y2=y))
        body.append(tag("text", show(value), class_="tick y", x=frame.left - 8, y=y + 4))
    room = 4 if frame.width < 420 else 7
    for value in ticks(0, frame.x_max, room):
        if value > frame.x_max * (1 + 1e-9):
            continue
        x = frame.x(value)
        body.append(tag("line", class_="axis", x1=x, x2=x, y1=base, y2=base + 4))
        body.append(tag("text", short(value), class_="tick x", x=x, y=base + 18))
    body.append(tag("line", class_="axis", x1=frame.left, x2=right, y1=base, y2=base))
    middle = (frame.left + right) / 2
    body.append(tag("text", "environment steps per seed", class_="label x", x=middle, y=base + 37))
    body.append(tag("text", unit, class_="label y", x=4, y=14))
    return tag("g", body, class_="axes")


def _series(frame: Frame, one: Series, show: Text) -> list[Markup]:
    body = []
    if len(one.seed_names) > 1:
        upper = _points(frame, one.steps, one.band.high)
        lower = _points(frame, one.steps, one.band.low)
        body.append(tag("path", class_="band", d=f"{_path(upper + lower[::-1])}Z"))
        for name, column in zip(one.seed_names, one.seeds.T, strict=True):
            about = tag("title", f"{one.label}, {name}")
            line = _path(_points(frame, one.steps, column))
            body.append(tag("path", about, class_="seed", d=line))
    body.append(tag("path", class_="mean", d=_path(_points(frame, one.steps, one.band.mean))))
    if len(one.steps) <= 40:
        for step, value, low, high in zip(
            one.steps, one.band.mean, one.band.low, one.band.high, strict=True
        ):
            if not np.isnan(value):
                said = f"step {step:,}: {show(value)} [{show(low)}, {show(high)}]"
                about = tag("title", said)
                body.append(
                    tag("circle", about, class_="point", cx=frame.x(step), cy=frame.y(value), r=2.6)
                )
    return body


def _level(frame: Frame, level: Level) -> Markup:
    y = frame.y(level.value)
    right = frame.width - frame.right
    return tag("line", class_=f"level {level.style}", x1=frame.left, x2=right, y1=y, y2=y)


def _level_names(frame: Frame, levels: Sequence[Level], show: Text) -> list[Markup]:
    """Names at the right end of their lines, pushed apart where lines are close."""
    body, last = [], -math.inf
    x = frame.width - frame.right + 8
    for level in sorted(levels, key=lambda one: -one.value):
        y = max(frame.y(level.value) + 4, last + 15)
        last = y
        said = f"{level.label.partition(',')[0]} {show(level.value)}"
        body.append(tag("text", said, class_=f"level-name {level.style}", x=x, y=y))
    return body


def _hover(frame: Frame, series: Sequence[Series], show: Text) -> list[list[object]]:
    """What the cursor says at each step: [x, heading, lines]."""
    said: dict[int, list[str]] = {}
    for one in series:
        for i, step in enumerate(one.steps):
            value, low, high = (float(c[i]) for c in (one.band.mean, one.band.low, one.band.high))
            if not math.isnan(value):
                line = f"{one.label}: {show(value)} [{show(low)}, {show(high)}]"
                said.setdefault(step, []).append(line)
    return [[round(frame.x(s), 1), f"step {s:,}", lines] for s, lines in sorted(said.items())]


def _points(frame: Frame, steps: Sequence[int], values: Floats) -> list[tuple[float, float]]:
    return [
        (frame.x(step), frame.y(float(value)))
        for step, value in zip(steps, values, strict=True)
        if not np.isnan(value)
    ]


def _path(points: Sequence[tuple[float, float]]) -> str:
    return "".join(f"{'L' if i else 'M'}{number(x)},{number(y)}" for i, (x, y) in enumerate(points))
