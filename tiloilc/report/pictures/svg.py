"""Canvases as SVG: one file that needs nothing else, the same text on every machine."""

from __future__ import annotations

import base64
from collections.abc import Sequence

from tiloilc.report.landscape import png
from tiloilc.report.markup import Markup, number, tag
from tiloilc.report.pictures.canvas import (
    PAPER,
    Box,
    Canvas,
    Clip,
    Disc,
    Look,
    Path,
    Photo,
    Ring,
    Shape,
    Text,
)

FONT = "system-ui, 'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif"


def svg_of(canvas: Canvas) -> str:
    """A whole SVG file."""
    width, height = number(canvas.width), number(canvas.height)
    paper = tag("rect", width=width, height=height, fill=PAPER)
    body = [_shape(shape) for shape in canvas.shapes]
    drawn = tag(
        "svg", tag("title", canvas.title), paper, body, xmlns="http://www.w3.org/2000/svg",
        role="img", font_family=FONT, width=width, height=height, viewBox=f"0 0 {width} {height}",
    )  # fmt: skip
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{drawn}\n'


def _shape(shape: Shape) -> Markup:
    match shape:
        case Disc():
            return tag("circle", cx=shape.x, cy=shape.y, r=shape.radius, **_look(shape.look))
        case Ring():
            rim = _circle(shape, shape.outer) + _circle(shape, shape.inner)
            return tag("path", d=rim, fill_rule="evenodd", **_look(shape.look))
        case Box():
            place = {"x": shape.x, "y": shape.y, "width": shape.width, "height": shape.height}
            return tag("rect", **place, **_look(shape.look))
        case Path():
            points = " ".join(f"{number(x)},{number(y)}" for x, y in shape.points)
            round_ends = {"stroke_linejoin": "round", "stroke_linecap": "round"}
            return tag("polyline", points=points, **round_ends, **_look(shape.look))
        case Text():
            return tag(
                "text", shape.text, x=shape.x, y=shape.y, font_size=shape.size, fill=shape.color,
                font_weight="bold" if shape.bold else None, text_anchor=shape.anchor,
                fill_opacity=None if shape.alpha == 1 else shape.alpha,
            )  # fmt: skip
        case Photo():
            href = "data:image/png;base64," + base64.b64encode(png(shape.pixels)).decode()
            place = {"x": shape.x, "y": shape.y, "width": shape.width, "height": shape.height}
            return tag("image", href=href, preserveAspectRatio="none", **place)
        case Clip():
            return _clipped(shape.frame, shape.shapes)


def _clipped(frame: Box, shapes: Sequence[Shape]) -> Markup:
    """An SVG inside the SVG shows what is in it only, and needs no names for that."""
    return tag(
        "svg", [_shape(shape) for shape in shapes], x=frame.x, y=frame.y, width=frame.width,
        height=frame.height, viewBox=" ".join(
            number(v) for v in (frame.x, frame.y, frame.width, frame.height)
        ),
    )  # fmt: skip


def _circle(ring: Ring, radius: float) -> str:
    r = number(radius)
    left, right = number(ring.x - radius), number(ring.x + radius)
    y = number(ring.y)
    return f"M{left},{y}A{r},{r} 0 1 0 {right},{y}A{r},{r} 0 1 0 {left},{y}Z"


def _look(look: Look) -> dict[str, str | float | None]:
    return {
        "fill": look.fill or "none",
        "fill_opacity": None if look.fill_alpha == 1 or not look.fill else look.fill_alpha,
        "stroke": look.stroke or None,
        "stroke_width": look.width if look.stroke else None,
        "stroke_opacity": None if look.alpha == 1 or not look.stroke else look.alpha,
    }
