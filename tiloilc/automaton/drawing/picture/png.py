"""Scenes as PNG. Graphviz draws them: shapes as its background, each line of text as a node.

It draws text of a background wrongly or not at all; that is why nodes do it.
"""

from __future__ import annotations

from collections.abc import Iterator

from tiloilc.automaton.drawing.graphviz import rendered
from tiloilc.automaton.drawing.picture.layout import Point
from tiloilc.automaton.drawing.picture.shapes import (
    LOOKS,
    PAPER,
    Area,
    Curve,
    Disc,
    Rectangle,
    Scene,
    Shape,
    Text,
)
from tiloilc.automaton.drawing.text import width

DOTS_PER_INCH = 144
"""Two dots a point: sharp on screens of today."""

MOST_DOTS = 12_000
"""On one side. Larger pictures are drawn with fewer dots a point."""

ROUND = 0.5523
"""Control points of a quarter circle of radius one."""


def png_bytes(scene: Scene) -> bytes:
    """The picture by day, two dots a point."""
    return rendered(_dot(scene), "png", "nop2")


def _dot(scene: Scene) -> str:
    shapes = [shape for group in scene.groups for shape in group.shapes]
    drawn = " +\n".join(f'"{_drawn(shape, scene.height)} "' for shape in shapes)
    longest = max(scene.width, scene.height, 1.0)
    dpi = min(DOTS_PER_INCH, int(MOST_DOTS * 72 / longest))
    bounds = f"0,0,{scene.width:.1f},{scene.height:.1f}"
    lines = [
        "graph {",
        f'graph [pad=0, dpi={dpi}, bgcolor="{PAPER}", bb="{bounds}", _background={drawn}];',
        'node [shape=none, margin=0, label="", fontname="monospace", fixedsize=shape];',
        _node("frame", scene.width / 2, scene.height / 2, scene.width, scene.height),
    ]
    texts = [shape for shape in shapes if isinstance(shape, Text)]
    lines += [_text(f"t{i}", text, scene.height) for i, text in enumerate(texts)]
    return "\n".join([*lines, "}", ""])


def _node(name: str, x: float, y: float, wide: float, high: float, more: str = "") -> str:
    size = f"width={wide / 72:.4f}, height={high / 72:.4f}"
    return f'{name} [pos="{x:.2f},{y:.2f}", {size}{more}];'


def _text(name: str, text: Text, height: float) -> str:
    look = LOOKS[text.role]
    wide = width([text.text], look.size)
    y = height - text.y + 0.34 * look.size  # the baseline is that much under the middle
    font = ', fontname="monospace bold"' if look.bold else ""
    escaped = text.text.replace("\\", "\\\\").replace('"', '\\"')
    escaped += "" if text.middle else "\\l"  # a line from the left end of its node
    x, room = (text.x, 0.1) if text.middle else (text.x + wide / 2, wide)
    more = f', label="{escaped}", fontsize={look.size:g}, fontcolor="{look.fill}"{font}'
    return _node(name, x, y, room, 0.1, more)


def _drawn(shape: Shape, height: float) -> str:
    """A shape in the language of xdot."""
    if isinstance(shape, Text):
        return ""
    look = LOOKS[shape.role]
    filled = look.fill != "none"
    line = look.stroke if look.stroke != "none" else look.fill
    pens = [_pen("c", line), _pen("C", look.fill) if filled else "", _style(look.width, look.dash)]
    match shape:
        case Curve(points):
            operation = f"B {_points(points, height)}"
        case Area(points):
            operation = f"{'P' if filled else 'p'} {_points(points, height)}"
        case Disc():
            place = f"{shape.x:.2f} {height - shape.y:.2f} {shape.radius:.2f} {shape.radius:.2f}"
            operation = f"{'E' if filled else 'e'} {place}"
        case Rectangle():
            outline = tuple(_outline(shape))
            parts = [f"b {_points(outline, height)}"] if filled else []
            if look.stroke != "none":
                parts.append(f"B {_points(outline, height)}")
            operation = " ".join(parts)
    return " ".join(pen for pen in [*pens, operation] if pen)


def _outline(box: Rectangle) -> Iterator[Point]:
    """The rim of a box with round corners, as one closed curve."""
    left, top, right, bottom = box.x, box.y, box.x + box.width, box.y + box.height
    r = max(box.radius, 0.01)
    bend = r * (1 - ROUND)
    corners = [
        ((right - r, top), (right - bend, top), (right, top + bend), (right, top + r)),
        ((right, bottom - r), (right, bottom - bend), (right - bend, bottom), (right - r, bottom)),
        ((left + r, bottom), (left + bend, bottom), (left, bottom - bend), (left, bottom - r)),
        ((left, top + r), (left, top + bend), (left + bend, top), (left + r, top)),
    ]
    last = (left + r, top)
    yield last
    for before, out, back, after in corners:
        yield from (last, before, before, out, back, after)
        last = after
    yield from (last, (left + r, top), (left + r, top))


def _points(points: tuple[Point, ...], height: float) -> str:
    return f"{len(points)} " + " ".join(f"{x:.2f} {height - y:.2f}" for x, y in points)


def _pen(operation: str, colour: str) -> str:
    return f"{operation} {len(colour)} -{colour}"


def _style(width: float, dash: str) -> str:
    kind, thick = "dashed" if dash else "solid", f"setlinewidth({width:g})"
    return f"S {len(kind)} -{kind} S {len(thick)} -{thick}"
