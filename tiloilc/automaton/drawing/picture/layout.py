"""Where things stand in a picture: Graphviz places boxes and routes edges between them.

Stages go from left to right: all states of one stage stand left of those of the next. States of one
stage that edges connect stand in columns of their own, so that no edge has to go straight up.
Graphviz is told all sizes, never a font: the layout is the same on every machine.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tiloilc.automaton.drawing.graphviz import rendered

Point = tuple[float, float]
"""In points, from the upper left corner."""

RANK_GAP = 30
"""Points between two columns, on each side of the labels between them."""

FAN = 4
"""Points more for each arrow after the sixth that meets one box."""

NODE_GAP = 16
"""Points between two boxes of a column."""

SLOT = 11.0
"""Points between two edges that leave a box on one side, if there is room."""

FADE = 60.0
"""How far from a box its edges are moved apart."""

ROUNDS = 50
"""How often labels are pushed apart."""

ONE_LINE = 18.0
"""Height of a label of one line, at most."""

STRAIGHT = 6
"""How much more a way to the next column wants to be straight than any other."""


@dataclass(frozen=True, slots=True)
class Box:
    """A state's place. `width` is its own; `height` with what stands over and under it."""

    width: float
    height: float
    solid: float
    """The height of the box itself, in the middle."""


@dataclass(frozen=True, slots=True)
class Arrow:
    """What leads from one state to another one, with the size of its label."""

    source: int
    target: int
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Route:
    """The Bézier curve of an arrow, from its source to its target, and the middle of its label."""

    curve: tuple[Point, ...]
    label: Point

    def along(self, steps: int = 24) -> Iterator[Point]:
        """Points of the curve, `steps` for each of its pieces and the end."""
        for k in range(0, len(self.curve) - 1, 3):
            (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.curve[k : k + 4]
            for i in range(steps):
                t, r = i / steps, 1 - i / steps
                p, q, u, v = r * r * r, 3 * r * r * t, 3 * r * t * t, t * t * t
                yield p * ax + q * bx + u * cx + v * dx, p * ay + q * by + u * cy + v * dy
        yield self.curve[-1]


@dataclass(frozen=True, slots=True)
class Layout:
    """The size of the whole, the middle of each box, the way of each arrow."""

    width: float
    height: float
    places: tuple[Point, ...]
    routes: tuple[Route, ...]


def columns_of(stages: Sequence[int], arrows: Sequence[Arrow]) -> list[int]:
    """The column of each state: by stage, then by the edges inside a stage, in state order."""
    depth = [0] * len(stages)
    inside = sorted(
        {
            (min(a.source, a.target), max(a.source, a.target))
            for a in arrows
            if stages[a.source] == stages[a.target] and a.source != a.target
        }
    )
    for first, second in inside:  # by the first: its own depth is known by then
        depth[second] = max(depth[second], depth[first] + 1)
    places = sorted(set(zip(stages, depth, strict=True)))
    return [places.index(place) for place in zip(stages, depth, strict=True)]


def laid_out(boxes: Sequence[Box], columns: Sequence[int], arrows: Sequence[Arrow]) -> Layout:
    """A layout of `boxes`, each in its column, and of `arrows` between boxes of two columns."""
    drawn = json.loads(rendered(_dot(boxes, columns, arrows), "json0"))
    left, low, right, high = (float(v) for v in drawn["bb"].split(","))

    def point(text: str) -> Point:
        x, y = text.split(",")
        return float(x) - left, high - float(y)

    nodes = {node["name"]: node for node in drawn.get("objects", []) if "pos" in node}
    places = tuple(point(nodes[f"n{b}"]["pos"]) for b in range(len(boxes)))
    routed = {edge["class"]: edge for edge in drawn.get("edges", []) if "class" in edge}
    routes = []
    for i, arrow in enumerate(arrows):
        edge = routed[f"a{i}"]
        curve = tuple(point(text) for text in edge["pos"].split())
        if columns[arrow.source] > columns[arrow.target]:
            curve = curve[::-1]
        routes.append(Route(curve, point(edge["lp"])))
    spread = _spread(boxes, columns, arrows, places, routes)
    return Layout(right - left, high - low, places, spread)


def _dot(boxes: Sequence[Box], columns: Sequence[int], arrows: Sequence[Arrow]) -> str:
    met = Counter(end for a in arrows for end in (a.source, a.target))
    gap = RANK_GAP + FAN * max(0, max(met.values(), default=0) - 6)
    lines = [
        "digraph {",
        f"rankdir=LR; nodesep={NODE_GAP / 72:.4f}; ranksep={gap / 72:.4f};",
        'node [shape=box, fixedsize=true, label=""]; edge [dir=none];',
    ]
    for b, box in enumerate(boxes):
        lines.append(f"n{b} [width={box.width / 72:.4f}, height={box.height / 72:.4f}];")
    lines.extend(_ranks(columns))
    for i, arrow in enumerate(arrows):
        ends = sorted((arrow.source, arrow.target), key=lambda b: columns[b])
        cell = f'FIXEDSIZE="TRUE" WIDTH="{arrow.width:.0f}" HEIGHT="{arrow.height:.0f}"'
        table = f'<TABLE BORDER="0" CELLSPACING="0"><TR><TD {cell}></TD></TR></TABLE>'
        onward = columns[arrow.target] == columns[arrow.source] + 1
        more = f"class=a{i}, weight={STRAIGHT if onward else 1}, label=<{table}>"
        lines.append(f"n{ends[0]}:e -> n{ends[1]}:w [{more}];")
    return "\n".join([*lines, "}", ""])


def _ranks(columns: Sequence[int]) -> Iterator[str]:
    """Each column a rank, in their order, whatever edges there are."""
    last = max(columns, default=0)
    for column in range(last + 1):
        members = [f"n{b};" for b, c in enumerate(columns) if c == column]
        yield f"c{column} [style=invis, width=0.01, height=0.01];"
        yield f"{{ rank=same; c{column}; {' '.join(members)} }}"
    for column in range(last):
        yield f"c{column} -> c{column + 1} [style=invis, weight=0];"


def _spread(
    boxes: Sequence[Box],
    columns: Sequence[int],
    arrows: Sequence[Arrow],
    places: Sequence[Point],
    routes: Sequence[Route],
) -> tuple[Route, ...]:
    """The routes with their ends side by side, in the order in which they go up or down."""
    sides: dict[tuple[int, bool], list[tuple[float, float, int, bool]]] = {}
    for i, (arrow, route) in enumerate(zip(arrows, routes, strict=True)):
        rightward = columns[arrow.source] < columns[arrow.target]
        for b, leaving in ((arrow.source, True), (arrow.target, False)):
            curve = route.curve if leaving else route.curve[::-1]
            near = curve[min(3, len(curve) - 1)][1]
            sides.setdefault((b, leaving == rightward), []).append(
                (near, route.label[1], i, leaving)
            )
    curves = [route.curve for route in routes]
    for (b, right), ends in sorted(sides.items()):
        room = boxes[b].solid - 14.0
        gap = min(SLOT, room / max(len(ends) - 1, 1))
        edge = places[b][0] + boxes[b].width / 2 * (1 if right else -1)
        for rank, (_, _, i, _) in enumerate(sorted(ends)):
            shift = (rank - (len(ends) - 1) / 2) * gap
            curves[i] = tuple(_shifted(point, edge, shift) for point in curves[i])
    moved = [Route(curve, route.label) for curve, route in zip(curves, routes, strict=True)]
    labels = [_beside(route, arrow) for route, arrow in zip(moved, arrows, strict=True)]
    placed = _apart(labels, arrows)
    return tuple(Route(r.curve, label) for r, label in zip(moved, placed, strict=True))


def _apart(labels: Sequence[Point], arrows: Sequence[Arrow]) -> list[Point]:
    """The labels without overlaps: pushed up and down until none is left, or for some rounds."""
    placed = list(labels)
    for _ in range(ROUNDS):
        moved = False
        for i, one in enumerate(arrows):
            for j, other in enumerate(arrows[:i]):
                (x, y), (u, v) = placed[i], placed[j]
                overlap = (one.height + other.height) / 2 + 1 - abs(y - v)
                if overlap > 0 and abs(x - u) < (one.width + other.width) / 2:
                    push = overlap / 2 if y >= v else -overlap / 2
                    placed[i], placed[j] = (x, y + push), (u, v - push)
                    moved = True
        if not moved:
            break
    return placed


def _beside(route: Route, arrow: Arrow) -> Point:
    """The middle of a label: on its line if that is in its way, over it if it has many lines."""
    x, y = route.label
    near = [q for p, q in route.along() if abs(p - x) <= arrow.width / 2]
    if not any(abs(q - y) <= arrow.height / 2 for q in near):
        return route.label
    if arrow.height <= ONE_LINE:
        closest = min(route.along(), key=lambda point: (abs(point[0] - x), abs(point[1] - y)))
        return x, closest[1]
    over = min(near) - arrow.height / 2
    return x, max(over, y - arrow.height / 2)


def _shifted(point: Point, edge: float, shift: float) -> Point:
    """A point moved down by `shift` at the side of a box, `edge`, and less further away."""
    x, y = point
    near = max(0.0, 1 - abs(x - edge) / FADE)
    return x, y + shift * near
