"""The pieces of a picture: states with what hangs on them, and what leads from one to another."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from tiloilc.automaton.drawing.picture.layout import Arrow, Box, Layout, Point
from tiloilc.automaton.drawing.picture.shapes import (
    LOOKS,
    Area,
    Curve,
    Disc,
    Group,
    Rectangle,
    Role,
    Shape,
    Text,
)
from tiloilc.automaton.drawing.text import width, wrapped
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.ldba import Ldba, StateId

NAME_WIDTH, NAME_LINES = 28, 4
GUARD_WIDTH, GUARD_LINES = 22, 4
"""Characters in a line, and lines; the rest is in the tooltip."""

LOOP = 17.0
"""Height of a self-loop's arc."""

DROP = 13.0
"""Length of each half of the arrow to ⊥, before and after its guard."""

PILL = 15.0
"""Height of the ⊥ box."""

PORT = 8.0
"""Room on the side of a box for each link after the first."""

LINE = 1.2
"""Height of a line, in font sizes."""


class HasIndex(Protocol):
    """The stages of an automaton: `index[b]` is how many stages lie before state b."""

    @property
    def index(self) -> Sequence[int]:
        """By state."""


@dataclass(frozen=True, slots=True)
class StatePiece:
    """The texts at one state, by line, and how many links meet it on one side, at most."""

    lines: tuple[str, ...]
    loop: tuple[str, ...]
    lost: tuple[str, ...]
    tooltip: str
    links: int

    @property
    def box(self) -> Box:
        """The room that it takes."""
        size = LOOKS["name"].size
        wide = max(
            width(self.lines, size),
            width(self.loop, LOOKS["small"].size),
            width(self.lost, LOOKS["awaytext"].size),
        )
        text = LINE * (LOOKS["number"].size + size * len(self.lines))
        solid = 14 + max(text, PORT * (self.links - 1))
        return Box(max(wide + 20, 46), solid + 2 * max(self.above, self.below), solid)

    @property
    def above(self) -> float:
        """Height of the self-loop with its guard."""
        return LOOP + LINE * LOOKS["small"].size * len(self.loop) + 4 if self.loop else 0.0

    @property
    def below(self) -> float:
        """Height of the arrow to ⊥ with its guard."""
        text = LINE * LOOKS["awaytext"].size * len(self.lost)
        return 2 * DROP + text + PILL if self.lost else 0.0


@dataclass(frozen=True, slots=True)
class Link:
    """What leads from a state to another live one: an edge, or a jump."""

    source: StateId
    target: StateId
    of: str
    lines: tuple[str, ...]
    tooltip: str
    jump: bool = False
    marked: bool = False

    @property
    def arrow(self) -> Arrow:
        """The link for the layout."""
        role: Role = "jumptext" if self.jump else "guard"
        size = LOOKS[role].size
        air = 30 if self.jump else 6  # so that its dashes are seen
        wide, high = width(self.lines, size) + air, LINE * size * len(self.lines) + 2
        return Arrow(self.source, self.target, wide, high)


def state_piece(
    ldba: Ldba,
    b: StateId,
    own: str,
    stages: HasIndex | None,
    links: int,
    notes: Mapping[str, str],
) -> StatePiece:
    """The texts of state `b`, of which `own` is what sets it apart."""

    def noted(of: str) -> tuple[str, ...]:
        return (notes[of],) if of in notes else ()

    guards: dict[bool, list[str]] = {True: [], False: []}
    for index in ldba.outgoing_indices[b]:
        edge = ldba.edges[index]
        if edge.target in (b, ldba.sink) and b != ldba.sink:
            text = guard_text(edge.guard, ldba.propositions)
            marked = "● " if index in ldba.accepting_edges else ""
            guards[edge.target == b] += wrapped(marked + text, GUARD_WIDTH, GUARD_LINES)
    kind = "lost" if b == ldba.sink else own
    stage = "" if stages is None else f", stage {stages.index[b]}"
    accepting = ", accepting" if b in ldba.accepting else ""
    return StatePiece(
        lines=(*(wrapped(kind, NAME_WIDTH, NAME_LINES) if kind else ()), *noted(f"state {b}")),
        loop=(*guards[True], *(noted(f"loop {b}") if guards[True] else ())),
        lost=(*guards[False], *(noted(f"lost {b}") if guards[False] else ())),
        tooltip=f"state {b}{stage}{accepting}\n{ldba.names[b]}",
        links=links,
    )


def links_of(ldba: Ldba, notes: Mapping[str, str]) -> Iterator[Link]:
    """All that leads from one live state to another one: edges, then jumps."""
    for index, edge in enumerate(ldba.edges):
        if edge.source == edge.target or ldba.sink in (edge.source, edge.target):
            continue
        guard = guard_text(edge.guard, ldba.propositions)
        marked = index in ldba.accepting_edges
        text = f"● {guard}" if marked else guard
        note = notes.get(f"edge {index}")
        lines = (*wrapped(text, GUARD_WIDTH, GUARD_LINES), *([] if note is None else [note]))
        tip = f"from {edge.source} to {edge.target} on\n{guard}"
        yield Link(edge.source, edge.target, f"edge {index}", lines, tip, marked=marked)
    for index, (source, target) in enumerate(ldba.jumps):
        tip = f"in {source} one may go on as in {target} (ε-jump)"
        yield Link(source, target, f"jump {index}", ("ε",), tip, jump=True)


def drawn_links(links: Sequence[Link], layout: Layout) -> Iterator[Group]:
    """All lines, then all labels, so that no line runs over a label."""
    for link, route in zip(links, layout.routes, strict=True):
        line: Role = "jump" if link.jump else "edge"
        head: Role = "jumphead" if link.jump else "head"
        yield Group(tuple(_arrow(route.curve, line, head)), link.of, link.tooltip)
    for link, route in zip(links, layout.routes, strict=True):
        role: Role = "jumptext" if link.jump else "guard"
        shapes = _label(link.lines, route.label, role, LOOKS[role].size)
        yield Group(tuple(shapes), link.of, link.tooltip)


def _label(lines: Sequence[str], middle: Point, role: Role, size: float) -> Iterator[Shape]:
    """Lines of text round `middle`, on paper, so that what crosses does not strike them out."""
    x, y = middle
    wide, high = width(lines, size) + 4, LINE * size * len(lines)
    yield Rectangle(x - wide / 2, y - high / 2, wide, high, 2, "paper")
    for i, line in enumerate(lines):
        yield Text(x, y - high / 2 + LINE * size * (i + 0.8), line, role)


def _arrow(curve: Sequence[Point], role: Role, head: Role, length: float = 7.0) -> Iterator[Shape]:
    """A curve with a head at its end."""
    (x0, y0), (x1, y1) = _before_end(curve), curve[-1]
    angle = math.atan2(y1 - y0, x1 - x0)
    back = (x1 - length * math.cos(angle), y1 - length * math.sin(angle))
    aside = (0.38 * length * math.sin(angle), -0.38 * length * math.cos(angle))
    yield Curve((*curve[:-1], back), role)
    sides = ((back[0] + aside[0], back[1] + aside[1]), (back[0] - aside[0], back[1] - aside[1]))
    yield Area((curve[-1], *sides), head)


def _before_end(curve: Sequence[Point]) -> Point:
    """The last point of the curve that is not its end."""
    end = curve[-1]
    return next((p for p in reversed(curve) if math.dist(p, end) > 1), (end[0] - 1, end[1]))


def drawn_state(ldba: Ldba, b: StateId, state: StatePiece, middle: Point) -> Iterator[Group]:
    """Box, self-loop and arrow to ⊥ of state `b`, its box round `middle`."""
    x, y = middle
    box = state.box
    left, top = x - box.width / 2, y - box.solid / 2
    if state.loop:
        yield Group(tuple(_loop(state, x, top)), f"loop {b}", f"stays in {b}")
    if state.lost:
        yield Group(tuple(_stub(state, x, y + box.solid / 2)), f"lost {b}", "lost for ever")
    role: Role = "lost" if b == ldba.sink else "accepting" if b in ldba.accepting else "box"
    shapes: list[Shape] = [Rectangle(left, top, box.width, box.solid, 8, role)]
    if b in ldba.accepting:
        inner = (left + 3, top + 3, box.width - 6, box.solid - 6)
        shapes.append(Rectangle(*inner, 5.5, "ring"))
    number, size = LOOKS["number"].size, LOOKS["name"].size
    text = LINE * (number + size * len(state.lines))
    base = y - text / 2 + 0.95 * number
    shapes.append(Text(x, base, str(b), "number"))
    for i, line in enumerate(state.lines):
        shapes.append(Text(x, base + LINE * size * (i + 1), line, "name"))
    yield Group(tuple(shapes), f"state {b}", state.tooltip)


def _loop(state: StatePiece, x: float, top: float) -> Iterator[Shape]:
    """A small arc on top of a box, its guard over it."""
    arc = ((x - 8, top), (x - 13, top - 1.35 * LOOP), (x + 13, top - 1.35 * LOOP), (x + 8, top))
    yield from _arrow(arc, "loop", "head", 5.0)
    size = LOOKS["small"].size
    for i, line in enumerate(reversed(state.loop)):
        yield Text(x, top - LOOP - 4 - LINE * size * i, line, "small")


def _stub(state: StatePiece, x: float, bottom: float) -> Iterator[Shape]:
    """A short arrow down to ⊥, its guard on the way."""
    size = LOOKS["awaytext"].size
    text = LINE * size * len(state.lost)
    end = bottom + 2 * DROP + text
    line = ((x, bottom), (x, bottom + 5), (x, end - 5), (x, end))
    yield from _arrow(line, "away", "awayhead", 5.0)
    yield from _label(state.lost, (x, bottom + DROP - 2 + text / 2), "awaytext", size)
    yield Rectangle(x - 11, end, 22, PILL, 4, "lost")
    yield Text(x, end + 11, "⊥", "awaytext")


def start_arrow(middle: Point, box: Box) -> Group:
    """The little arrow into the initial state."""
    x, y = middle[0] - box.width / 2, middle[1]
    line = ((x - 24, y), (x - 16, y), (x - 8, y), (x, y))
    return Group((Disc(x - 24, y, 2.5, "mark"), *_arrow(line, "edge", "head")), tooltip="start")
