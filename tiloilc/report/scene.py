"""Trajectories over a task's map, one small picture a seed, and as bars of automaton states."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tiloilc.report.maps import Map, Shape, cropped
from tiloilc.report.markup import Markup, number, tag
from tiloilc.report.runs.run import Trajectories
from tiloilc.report.states import State

__all__ = ["SIZE", "apart", "outlines", "panels", "timeline"]

SIZE = 220.0
"""Height of one picture in its own units."""


def panels(
    paths: Trajectories, drawn: Map, states: Sequence[State], names: Sequence[str]
) -> Markup:
    """A grid of pictures: the map, and over it each seed's path in the colours of its states."""
    drawn = cropped(drawn, drawn.places(paths.observations)[paths.states >= 0])
    pictures = []
    for seed, name in enumerate(names):
        run = _lived(paths.states[seed])
        visits = sum(1 for b in run[1:] if states[b].kind == "accepting")
        fell = next((t for t, b in enumerate(run) if states[b].kind == "sink"), None)
        said = f"{visits} visit{'' if visits == 1 else 's'}"
        if fell is not None:
            said += f", sink at step {fell}"
        points = drawn.places(paths.observations[seed, : len(run)])
        pictures.append(
            tag(
                "figure",
                _picture(points, run, drawn, states, f"{name}: {said}"),
                tag("figcaption", tag("b", name), " ", tag("span", said)),
            )
        )
    return tag("div", pictures, class_="panels")


def timeline(
    paths: Trajectories, states: Sequence[State], names: Sequence[str], width: float
) -> Markup:
    """The automaton state at each step of one episode a seed, as a row of coloured bars."""
    last = paths.states.shape[1] - 1
    left, row = 60.0, 17.0
    scale = (width - left - 10) / (last + 1)
    body = []
    for seed, name in enumerate(names):
        y = seed * row
        body.append(tag("text", name, class_="tick y", x=left - 8, y=y + 12))
        run = _lived(paths.states[seed])
        for start, stop in _stretches(run):
            state = states[run[start]]
            about = tag("title", f"{name}, steps {start}–{stop - 1}: {state.label}")
            body.append(
                tag(
                    "rect", about, x=left + start * scale, y=y + 1.5,
                    width=max((stop - start) * scale, 0.75), height=row - 3, fill=state.color,
                )
            )  # fmt: skip
    base = len(names) * row
    for step in range(0, last + 1, max(1, _round(last / 5))):
        x = left + step * scale
        body.append(tag("line", class_="axis", x1=x, x2=x, y1=base, y2=base + 4))
        body.append(tag("text", str(step), class_="tick x", x=x, y=base + 17))
    middle = left + (width - left) / 2
    body.append(tag("text", "step of the episode", class_="label x", x=middle, y=base + 35))
    title = "Automaton state at each step of one greedy episode a seed"
    return tag(
        "svg", tag("title", title), body, class_="chart timeline", role="img", aria_label=title,
        viewBox=f"0 0 {number(width)} {number(base + 42)}", width=width, height=base + 42,
    )  # fmt: skip


def _picture(
    points: npt.NDArray[np.float64],
    run: npt.NDArray[np.int64],
    drawn: Map,
    states: Sequence[State],
    title: str,
) -> Markup:
    x_min, y_min, x_max, y_max = drawn.bounds
    scale = SIZE / max(y_max - y_min, (x_max - x_min) / 3)
    width, height = (x_max - x_min) * scale, (y_max - y_min) * scale
    placed = np.stack([(points[:, 0] - x_min) * scale, (y_max - points[:, 1]) * scale], axis=1)
    body = [tag("rect", class_="ground", width=width, height=height)]
    body += outlines(drawn, x_min, y_max, scale)
    if any(drawn.axes):
        across, up = drawn.axes
        body.append(tag("text", across, class_="zone-name", x=width / 2, y=height - 6))
        turned = f"rotate(-90 12 {number(height / 2)})"
        body.append(tag("text", up, class_="zone-name", x=12, y=height / 2, transform=turned))
    fell = next((t for t, b in enumerate(run) if states[b].kind == "sink"), len(run) - 1)
    lines, dots = [], []
    for start, stop in _stretches(run[: fell + 1]):
        way = placed[start : min(stop, fell) + 1]
        color = states[run[start]].color
        path = " ".join(f"{number(x)},{number(y)}" for x, y in way)
        lines.append(tag("polyline", points=path, stroke=color))
        dots += [tag("circle", cx=x, cy=y, r=1.7, fill=color) for x, y in placed[start:stop]]
    body.append(tag("g", lines, class_="way"))
    body.append(tag("g", dots, class_="steps"))
    for t, _ in _stretches(run[: fell + 1]):  # where it stays accepting, one mark is enough
        if t and states[run[t]].kind == "accepting":
            at = {"cx": placed[t, 0], "cy": placed[t, 1]}
            about = tag("title", f"step {t}: accepting")
            body.append(tag("circle", about, class_="goal", r=4.6, fill=states[run[t]].color, **at))
    body.append(tag("circle", tag("title", "start"), class_="start", r=4.6,
                    cx=placed[0, 0], cy=placed[0, 1]))  # fmt: skip
    if states[run[fell]].kind == "sink":
        x, y = (number(v) for v in placed[fell])
        about = tag("title", f"step {fell}: sink")
        body.append(tag("path", about, class_="fell", d=f"M{x},{y}m-5,-5l10,10m0,-10l-10,10"))
    return tag("svg", tag("title", title), body, class_="scene", role="img", aria_label=title,
               viewBox=f"0 0 {number(width)} {number(height)}")  # fmt: skip


def outlines(drawn: Map, x_min: float, y_max: float, scale: float) -> list[Markup]:
    """The map's zones in a picture whose upper left corner is (x_min, y_max)."""
    zones = [(shape.name, *_shape(shape, x_min, y_max, scale)) for shape in drawn.shapes]
    named = [(name, place) for name, _, place in zones if name]
    places = apart([place for _, place in named], 13.0)
    # names over all areas, for areas overlap
    return [
        *(area for _, area, _ in zones),
        *(
            tag("text", name, class_="zone-name", x=x, y=y + 4)
            for (name, _), (x, y) in zip(named, places, strict=True)
        ),
    ]


def apart(places: Sequence[tuple[float, float]], size: float) -> list[tuple[float, float]]:
    """Where names of a font `size` can be read: each below those that it would lie over.

    The last ones keep their places: they are of what lies uppermost, and is small.
    """
    found: list[tuple[float, float]] = []
    for x, y in reversed(places):
        while any(abs(x - other) < 3 * size and abs(y - up) < size for other, up in found):
            y += 1.15 * size
        found.append((x, y))
    return found[::-1]


def _shape(
    shape: Shape, x_min: float, y_max: float, scale: float
) -> tuple[Markup, tuple[float, float]]:
    """A zone's area, and the middle of its name."""
    x, y = (shape.low[0] - x_min) * scale, (y_max - shape.low[1]) * scale
    stroke = shape.color if shape.edge else None
    style = {"class_": "zone", "fill": shape.color, "stroke": stroke}
    about = tag("title", shape.name) if shape.name else ""
    if shape.inner:
        rims = [_rim(x, y, shape.radius * scale), _rim(x, y, shape.inner * scale)]
        area = tag("path", about, d="".join(rims), fill_rule="evenodd", **style)
        middle = (x, y + (shape.inner + shape.radius) / 2 * scale)
    elif shape.radius:
        area = tag("circle", about, cx=x, cy=y, r=shape.radius * scale, **style)
        middle = (x, y)
    else:
        across = (shape.high[0] - shape.low[0]) * scale
        up = (shape.high[1] - shape.low[1]) * scale
        area = tag("rect", about, x=x, y=y - up, width=across, height=up, **style)
        middle = (x + across / 2, y - up / 2)
    return area, middle


def _rim(x: float, y: float, radius: float) -> str:
    """A circle as part of a path."""
    left, right, r = number(x - radius), number(x + radius), number(radius)
    return (
        f"M{left},{number(y)}A{r},{r} 0 1 0 {right},{number(y)}A{r},{r} 0 1 0 {left},{number(y)}Z"
    )


def _lived(run: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """The states up to the end of the episode, which negative ones pad."""
    over = np.flatnonzero(run < 0)
    return run[: over[0]] if over.size else run


def _stretches(run: npt.NDArray[np.int64]) -> list[tuple[int, int]]:
    """The stretches [start, stop) of equal states."""
    cuts = [0, *(np.flatnonzero(np.diff(run)) + 1).tolist(), len(run)]
    return list(itertools.pairwise(cuts))


def _round(value: float) -> int:
    """The nearest of 1, 2, 5, 10, 20, 50, … at or above `value`."""
    step = 1
    while True:
        for factor in (1, 2, 5):
            if factor * step >= value:
                return factor * step
        step *= 10
