"""What a person sees of an automaton at a glance.

Stages go from left to right. A state is a box with its number and what sets it apart from the
others, two lines round it if it accepts; its self-loop is a small arc on top. What loses for ever
is a short grey arrow down to ⊥, so that the sink's edges do not cover the ones that matter.
ε-jumps are dashed. Guards are short formulas; what is cut is whole in the tooltip.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from tiloilc.automaton.drawing.picture.layout import (
    Arrow,
    Box,
    Layout,
    Route,
    columns_of,
    laid_out,
)
from tiloilc.automaton.drawing.picture.pieces import (
    LINE,
    HasIndex,
    Link,
    drawn_links,
    drawn_state,
    links_of,
    start_arrow,
    state_piece,
)
from tiloilc.automaton.drawing.picture.shapes import (
    LOOKS,
    Area,
    Curve,
    Group,
    Rectangle,
    Scene,
    Shape,
    Text,
)
from tiloilc.automaton.drawing.text import own_parts, width, wrapped
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.ldba import Ldba, StateId

MARGIN = 16.0
"""Points round everything."""

MOST_LINKS = 250
"""Arrows between boxes. Beyond, nobody sees anything, and placing them takes many seconds."""

MOST_STATES = 120

KEYS = {
    "accepting": "double border: accepting",
    "mark": "●: accepting edge",
    "jump": "dashed ε: may go on as there",
    "lost": "⊥: lost for ever",
}


def too_large(ldba: Ldba) -> str:
    """Why nobody would see anything in a picture of `ldba`; empty if it can be drawn."""
    links = sum(e.source != e.target and ldba.sink not in (e.source, e.target) for e in ldba.edges)
    links += len(ldba.jumps)
    if links <= MOST_LINKS and len(ldba.names) <= MOST_STATES:
        return ""
    return f"it has {len(ldba.names)} states and {links} edges between them"


def picture(
    ldba: Ldba,
    stages: HasIndex | None = None,
    title: str | None = None,
    notes: Mapping[str, str] | None = None,
) -> Scene:
    """`ldba` as a scene under its `title`, a formula; with `stages`, headings over the columns.

    `notes` are added to the texts of groups, by what these are of.

    A scene that says so if `ldba` is `too_large`.
    """
    if why := too_large(ldba):
        return _notice(f"This automaton is not drawn: {why}.", title, _description(ldba, stages))
    live = [b for b in ldba.states if b != ldba.sink] or [ldba.initial]
    notes = notes or {}
    links = list(links_of(ldba, notes))
    place = {b: i for i, b in enumerate(live)}
    arrows = [_renumbered(link.arrow, place) for link in links]
    order = _depths(len(live), arrows) if stages is None else [stages.index[b] for b in live]
    columns = columns_of(order, arrows)
    own = own_parts(ldba, title)
    states = {
        b: state_piece(ldba, b, own[b], stages, _met(place[b], columns, arrows), notes)
        for b in live
    }
    boxes = [states[b].box for b in live]
    layout = laid_out(boxes, columns, arrows)
    groups = [*drawn_links(links, layout)]
    for b in live:
        groups += drawn_state(ldba, b, states[b], layout.places[place[b]])
    groups.append(start_arrow(layout.places[place[ldba.initial]], boxes[place[ldba.initial]]))
    headings = {} if stages is None else _headings(order, boxes, layout)
    keys = [text for role, text in KEYS.items() if role in _shown(ldba, links)]
    return _framed(groups, layout, title, headings, keys, _description(ldba, stages))


def _met(b: int, columns: Sequence[int], arrows: Sequence[Arrow]) -> int:
    """How many arrows meet the box `b` on that side where there are more."""
    ends = [{a.source, a.target} for a in arrows]
    right = sum(b in pair and columns[b] < max(columns[c] for c in pair) for pair in ends)
    return max(right, sum(b in pair for pair in ends) - right)


def _notice(text: str, title: str | None, description: str) -> Scene:
    """A picture of nothing but words."""
    shape = Text(0, 0, text, "key", middle=False)
    wide = width([text], LOOKS["key"].size)
    return _framed([Group((shape,))], Layout(wide, 0, (), ()), title, {}, [], description)


def _renumbered(arrow: Arrow, place: dict[StateId, int]) -> Arrow:
    return Arrow(place[arrow.source], place[arrow.target], arrow.width, arrow.height)


def _depths(count: int, arrows: Sequence[Arrow]) -> list[int]:
    """The distance of each state from the first."""
    depth = {0: 0}
    queue = [0]
    for b in queue:
        for arrow in arrows:
            if arrow.source == b and arrow.target not in depth:
                depth[arrow.target] = depth[b] + 1
                queue.append(arrow.target)
    return [depth.get(b, 0) for b in range(count)]


def _shown(ldba: Ldba, links: Sequence[Link]) -> set[str]:
    """The keys of KEYS that there is something of."""
    found = {"jump"} if any(link.jump for link in links) else set()
    found |= {"accepting"} if ldba.accepting else set()
    found |= {"mark"} if ldba.accepting_edges else set()
    return found | ({"lost"} if ldba.sink is not None else set())


def _headings(
    order: Sequence[int], boxes: Sequence[Box], layout: Layout
) -> dict[int, tuple[float, float]]:
    """From where to where each stage goes."""
    spans: dict[int, tuple[float, float]] = {}
    for stage, box, (x, _) in zip(order, boxes, layout.places, strict=True):
        left, right = spans.get(stage, (math.inf, -math.inf))
        spans[stage] = min(left, x - box.width / 2), max(right, x + box.width / 2)
    return spans


def _framed(
    groups: Sequence[Group],
    layout: Layout,
    title: str | None,
    headings: dict[int, tuple[float, float]],
    keys: Sequence[str],
    description: str,
) -> Scene:
    """The groups with title and headings over them and the key under them."""
    start = 28.0
    wide = max(layout.width + start + 2 * MARGIN, 260.0)
    head, stage, key = (LOOKS[role].size for role in ("title", "stage", "key"))
    across = int((wide - 2 * MARGIN) / width("0", head))
    titles = wrapped(title, across, 4) if title else []
    top = MARGIN + LINE * head * len(titles) + (6 if titles else 0)
    frame: list[Shape] = [
        Text(MARGIN, MARGIN + LINE * head * (i + 0.8), line, "title", middle=False)
        for i, line in enumerate(titles)
    ]
    left = MARGIN + start
    if headings:
        for number, (begin, end) in sorted(headings.items()):
            middle = left + (begin + end) / 2
            frame.append(Text(middle, top + stage, f"stage {number}", "stage"))
            ends = (left + begin, top + stage + 6), (left + end, top + stage + 6)
            frame.append(Curve((ends[0], *ends, ends[1]), "rule"))
        top += stage + 16
    ys = [y for group in groups for shape in group.shapes for y in _heights(shape)]
    down = top - min(ys)
    bottom = down + max(ys) + 14
    lines = _key_lines(keys, wide - 2 * MARGIN)
    for i, line in enumerate(lines):
        frame.append(Text(MARGIN, bottom + LINE * key * (i + 0.8), line, "key", middle=False))
    high = bottom + LINE * key * len(lines) + MARGIN * 0.75
    wide = max(wide, width(titles, head) + 2 * MARGIN, width(lines, key) + 2 * MARGIN)
    moved = [_moved(group, left, down) for group in groups]
    paper = Group((Rectangle(0, 0, wide, high, 0, "paper"),))
    named = f"Automaton of {title}" if title else "Automaton"
    return Scene(wide, high, named, description, (paper, *moved, Group(tuple(frame))))


def _key_lines(keys: Sequence[str], room: float) -> list[str]:
    lines: list[str] = []
    for key in keys:
        joined = f"{lines[-1]}   {key}" if lines else key
        if lines and width([joined], LOOKS["key"].size) <= room:
            lines[-1] = joined
        else:
            lines.append(key)
    return lines


def _heights(shape: Shape) -> Iterator[float]:
    """How far a shape goes up and down."""
    if isinstance(shape, Curve):
        yield from (y for _, y in Route(shape.points, shape.points[0]).along())
    elif isinstance(shape, Rectangle):
        yield from (shape.y, shape.y + shape.height)
    elif isinstance(shape, Text):
        yield from (shape.y - LOOKS[shape.role].size, shape.y + 3)


def _moved(group: Group, right: float, down: float) -> Group:
    return Group(tuple(_shifted(s, right, down) for s in group.shapes), group.of, group.tooltip)


def _shifted(shape: Shape, dx: float, dy: float) -> Shape:
    if isinstance(shape, Curve | Area):
        return replace(shape, points=tuple((x + dx, y + dy) for x, y in shape.points))
    return replace(shape, x=shape.x + dx, y=shape.y + dy)


def _description(ldba: Ldba, stages: HasIndex | None) -> str:
    """The picture in words."""
    parts = []
    for b in ldba.states:
        if b == ldba.sink:
            continue
        notes = ["start"] if b == ldba.initial else []
        notes += ["accepting"] if b in ldba.accepting else []
        notes += [] if stages is None else [f"stage {stages.index[b]}"]
        noted = f" ({', '.join(notes)})" if notes else ""
        told = f"State {b}{noted}: {ldba.names[b]}."
        for index in ldba.outgoing_indices[b]:
            edge = ldba.edges[index]
            guard = guard_text(edge.guard, ldba.propositions)
            where = "stays" if edge.target == b else f"to {edge.target}"
            where = "lost for ever" if edge.target == ldba.sink else where
            marked = ", accepting" if index in ldba.accepting_edges else ""
            told += f" On {guard} {where}{marked}."
        for target in ldba.jump_targets[b]:
            told += f" May go on as state {target}."
        parts.append(told)
    return "\n".join(parts) or "No word is accepted: all is lost from the start."
