"""The picture of an environment with one episode in it, and the sheet of many such."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from tiloilc.report.maps import Map, cropped
from tiloilc.report.pictures.canvas import (
    CARD,
    INK,
    LINE,
    SOFT,
    Box,
    Canvas,
    Look,
    Pixels,
    Shape,
    Text,
    fitted,
    width_of,
)
from tiloilc.report.pictures.place import Episode, bars, on_map, photo_in, view_in
from tiloilc.report.states import State

WIDTH, EDGE, LINE_HEIGHT = 720.0, 20.0, 19.0
MOST_HEIGHT = 460.0
"""Of the map, which may be a long corridor or a tower."""

STRIP = 4
"""Frames of an episode that are shown."""

COLUMNS, CELL, GAP = 5, (300.0, 250.0), 18.0
"""Of a sheet: cells in a row, the width and height of a cell's picture, and what is between."""


@dataclass(frozen=True, eq=False)
class Shown:
    """What there is to show of a task: its map, frames by step, an episode and its states.

    `about` says in a line whose episode it is, and in further ones what happened.
    """

    title: str
    goal: str
    about: str
    drawn: Map | None
    frames: dict[int, Pixels]
    episode: Episode | None
    states: tuple[State, ...]


def moments(episode: Episode, count: int = STRIP) -> list[int]:
    """Steps worth a frame: the beginning, first arrivals in states, spread over them, the end."""
    run = episode.states.tolist()
    last, room = len(run) - 1, max(0, count - 2)
    arrivals = sorted(run.index(b) for b in set(run) if b != run[0])
    if len(arrivals) > room:
        arrivals = [
            arrivals[round(i * (len(arrivals) - 1) / max(1, room - 1))] for i in range(room)
        ]
    return sorted({0, *arrivals, last})


def highlight(episode: Episode, accepting: Collection[int]) -> int:
    """The step worth the only frame: the first accepting visit, else the end."""
    visits = [t for t, b in enumerate(episode.states.tolist()) if t and b in accepting]
    return visits[0] if visits else len(episode.states) - 1


def environment_picture(shown: Shown) -> Canvas:
    """A task's map with its episode, frames of it, the states over time, and what colours mean."""
    wide = WIDTH - 2 * EDGE
    shapes: list[Shape] = [
        Text(EDGE, 34, fitted(shown.title, 18, wide), 18, bold=True),
        Text(EDGE, 56, fitted(shown.goal, 13, wide), 13, SOFT),
    ]
    y = 72.0
    if shown.drawn is not None:
        drawn = _with_path(shown.drawn, shown.episode)
        x_min, y_min, x_max, y_max = drawn.bounds
        high = min(MOST_HEIGHT, wide * (y_max - y_min) / (x_max - x_min))
        view = view_in(drawn, Box(EDGE, y, wide, high, Look()))
        episodes = [] if shown.episode is None else [shown.episode]
        shapes += on_map(drawn, episodes, shown.states, view)
        y += high + 14
    if shown.frames:
        strip = list(_strip(shown, EDGE, y, wide))
        shapes += strip
        y = max(s.y for s in strip if isinstance(s, Text)) + 14
    if shown.episode is not None:
        shapes += bars(shown.episode.states, shown.states, Box(EDGE, y, wide, 12, Look()))
        for i, line in enumerate(shown.about.split("\n")):
            shapes.append(Text(EDGE, y + 29, fitted(line, 12, wide), 12, SOFT if i == 0 else INK))
            y += 17
        y += 25
    y += 6
    for state in in_order(shown.states):
        shapes += key(state, EDGE, y, wide)
        y += LINE_HEIGHT
    return Canvas(WIDTH, y + EDGE - 4, f"{shown.title}: {shown.goal}", tuple(shapes))


def sheet(tasks: Sequence[Shown], title: str) -> Canvas:
    """Many tasks side by side, each with its episode and its states over time."""
    across, high = CELL
    columns = min(COLUMNS, max(1, len(tasks)))
    row = high + 62 + GAP
    width = 2 * EDGE + columns * across + (columns - 1) * GAP
    shapes: list[Shape] = [Text(EDGE, 36, fitted(title, 20, width - 2 * EDGE), 20, bold=True)]
    shapes += _colours(EDGE, 60)
    top = 84.0
    for i, task in enumerate(tasks):
        x = EDGE + (i % columns) * (across + GAP)
        y = top + (i // columns) * row
        shapes.append(Text(x, y + 13, fitted(task.title, 14, across), 14, bold=True))
        shapes.append(Text(x, y + 30, fitted(task.goal, 11, across), 11, SOFT))
        shapes += _cell(task, Box(x, y + 38, across, high, Look()))
        if task.episode is not None:
            strip = Box(x, y + 38 + high + 4, across, 8, Look())
            shapes += bars(task.episode.states, task.states, strip)
    rows = -(-len(tasks) // columns)
    return Canvas(width, top + rows * row + EDGE - GAP, title, tuple(shapes))


def in_order(states: Sequence[State]) -> list[State]:
    """Stages, then acceptance, then the sink."""
    rank = {"live": 0, "accepting": 1, "sink": 2}
    return sorted(states, key=lambda s: (rank[s.kind], s.stage, s.number))


def key(state: State, x: float, y: float, width: float) -> Iterator[Shape]:
    """A line that says what a colour means."""
    yield Box(x, y, 12, 12, Look(state.color))
    yield Text(x + 20, y + 10.5, fitted(said(state), 12, width - 20), 12)


def said(state: State, named: bool = True) -> str:
    """A state in words: its stage and, if it is to be named, what is left to do."""
    if state.kind == "sink":
        return "lost for ever"
    what = "accepting" if state.kind == "accepting" else f"stage {state.stage}"
    return what if not named or state.name in ("", "true") else f"{what} · {state.name}"


def _colours(x: float, y: float) -> Iterator[Shape]:
    """What colours and marks mean on every picture of a sheet."""
    from tiloilc.report.states import ACCEPTING, LIVE, SINK

    words = "Each with a demonstration in the colours of its automaton's states: stages"
    yield Text(x, y, words, 12, SOFT)
    x += width_of(words, 12) + 4
    for color in LIVE:
        yield Box(x, y - 10, 12, 12, Look(color))
        x += 14
    for color, words in ((ACCEPTING[0], "accepting"), (SINK, "lost")):
        x += 12
        yield Box(x, y - 10, 12, 12, Look(color))
        yield Text(x + 18, y, words, 12, SOFT)
        x += 18 + width_of(words, 12)


def _cell(task: Shown, room: Box) -> Iterator[Shape]:
    """The map, or a frame, or both side by side."""
    rooms = [room]
    if task.drawn is not None and task.frames:
        half = (room.width - 4) / 2
        rooms = [
            Box(room.x, room.y, half, room.height, Look()),
            Box(room.x + half + 4, room.y, half, room.height, Look()),
        ]
    if task.drawn is not None:
        drawn = _with_path(task.drawn, task.episode)
        episodes = [] if task.episode is None else [task.episode]
        yield from on_map(drawn, episodes, task.states, view_in(drawn, rooms[0]))
    if task.frames:
        yield photo_in(task.frames[max(task.frames)], rooms[-1])
    if task.drawn is None and not task.frames:
        middle = room.x + room.width / 2
        yield Box(room.x, room.y, room.width, room.height, Look(CARD, LINE))
        yield Text(middle, room.y + room.height / 2, "no picture here", 12, SOFT, "middle")


def _strip(shown: Shown, x: float, y: float, width: float) -> Iterator[Shape]:
    """Frames side by side, each under the colour of the state it was taken in."""
    columns = STRIP if shown.drawn is not None or len(shown.frames) > 2 else 2
    wide = (width - (columns - 1) * 8) / columns
    high = max(wide * p.shape[0] / p.shape[1] for p in shown.frames.values())
    for i, (step, pixels) in enumerate(sorted(shown.frames.items())):
        left, top = x + i % columns * (wide + 8), y + i // columns * (high + 28)
        words, color = f"step {step}", INK
        if shown.episode is not None:
            state = shown.states[int(shown.episode.states[step])]
            words, color = f"step {step}: {said(state, named=False)}", state.color
        yield Box(left, top, wide, 4, Look(color))
        yield photo_in(pixels, Box(left, top + 4, wide, high, Look()))
        yield Text(left, top + high + 17, fitted(words, 11, wide), 11, SOFT)


def _with_path(drawn: Map, episode: Episode | None) -> Map:
    """The part of the map where there is something."""
    return cropped(drawn, None if episode is None else drawn.places(episode.observations))
