"""Scenes as SVG: the same text on every machine, legible by day, by night and in grey.

No ids, so that a picture can stand in a page several times; no scripts, no fonts to be fetched.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from tiloilc.automaton.drawing.picture.layout import Point
from tiloilc.automaton.drawing.picture.shapes import (
    LOOKS,
    Area,
    Curve,
    Disc,
    Group,
    Look,
    Rectangle,
    Scene,
    Shape,
)

FONT = "ui-monospace,'DejaVu Sans Mono',Menlo,Consolas,'Liberation Mono',monospace"


def svg_text(scene: Scene) -> str:
    """A whole SVG file."""
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + svg_element(scene)


def svg_element(scene: Scene) -> str:
    """The element alone, as it stands in HTML; ended by a newline."""
    width, height = _number(scene.width), _number(scene.height)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="ldba" role="img" '
        f'width="{width}" height="{height}" viewBox="0 0 {width} {height}">',
        f"<title>{escape(scene.title, quote=False)}</title>",
        f"<desc>{escape(scene.description, quote=False)}</desc>",
        f"<style>{_css(scene)}</style>",
        f'<rect class="ldba-paper" width="{width}" height="{height}"/>',
    ]
    for group in scene.groups:
        lines.extend(_group(group))
    return "\n".join([*lines, "</svg>", ""])


def _group(group: Group) -> Iterator[str]:
    kind, _, number = group.of.partition(" ")
    yield f'<g data-{kind}="{number}">' if kind else "<g>"
    if group.tooltip:
        yield f"<title>{escape(group.tooltip, quote=False)}</title>"
    for shape in group.shapes:
        yield _shape(shape)
    yield "</g>"


def _shape(shape: Shape) -> str:
    look = f'class="ldba-{shape.role}"'
    match shape:
        case Curve(points):
            return f'<path {look} d="{_path(points)}"/>'
        case Area(points):
            corners = " ".join(f"{_number(x)},{_number(y)}" for x, y in points)
            return f'<polygon {look} points="{corners}"/>'
        case Rectangle():
            size = f'width="{_number(shape.width)}" height="{_number(shape.height)}"'
            place = f'x="{_number(shape.x)}" y="{_number(shape.y)}"'
            return f'<rect {look} {place} {size} rx="{_number(shape.radius)}"/>'
        case Disc():
            place = f'cx="{_number(shape.x)}" cy="{_number(shape.y)}"'
            return f'<circle {look} {place} r="{_number(shape.radius)}"/>'
        case _:
            place = f'x="{_number(shape.x)}" y="{_number(shape.y)}"'
            look = look if shape.middle else f'class="ldba-{shape.role} ldba-start"'
            return f"<text {look} {place}>{escape(shape.text, quote=False)}</text>"


def _path(points: tuple[Point, ...]) -> str:
    texts = [f"{_number(x)} {_number(y)}" for x, y in points]
    return f"M{texts[0]} C{' '.join(texts[1:])}"


def _css(scene: Scene) -> str:
    """Rules of the roles that the picture has, first by day, then those that differ by night."""
    used = {shape.role for group in scene.groups for shape in group.shapes} | {"paper"}
    roles = [role for role in LOOKS if role in used]
    rules = [f".ldba text{{font-family:{FONT};text-anchor:middle;white-space:pre}}"]
    rules += [f".ldba-{role}{{{_rule(LOOKS[role])}}}" for role in roles]
    rules.append(".ldba text.ldba-start{text-anchor:start}")
    dark = [f".ldba-{role}{{{_colours(*LOOKS[role].night)}}}" for role in roles]
    rules.append(f"@media screen and (prefers-color-scheme:dark){{{''.join(dark)}}}")
    return "\n".join(["", *rules, ""])


def _rule(look: Look) -> str:
    parts = [_colours(look.stroke, look.fill)]
    if look.stroke != "none":
        parts.append(f"stroke-width:{_number(look.width)}")
    if look.dash:
        parts.append(f"stroke-dasharray:{look.dash}")
    if look.size:
        parts.append(f"font-size:{_number(look.size)}px")
    if look.bold:
        parts.append("font-weight:bold")
    return ";".join(parts)


def _colours(stroke: str, fill: str) -> str:
    return f"stroke:{stroke};fill:{fill}"


def _number(value: float) -> str:
    """At most one place: a tenth of a point is less than anyone sees."""
    shown = f"{value:.1f}".removesuffix(".0")
    return "0" if shown == "-0" else shown
