"""One episode drawn: its path over the map in the colours of its states, or as a row of bars."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tiloilc.report.maps import Map
from tiloilc.report.maps import Shape as Zone
from tiloilc.report.pictures.canvas import (
    CARD,
    INK,
    LINE,
    PAPER,
    SOFT,
    Box,
    Clip,
    Disc,
    Look,
    Path,
    Photo,
    Pixels,
    Plain,
    Point,
    Ring,
    Shape,
    Text,
)
from tiloilc.report.scene import apart
from tiloilc.report.states import SINK, State

ROUGH = 150
"""Steps of an episode beyond which they are no longer marked one by one."""


@dataclass(frozen=True, eq=False)
class Episode:
    """`observations` [T+1, d] and the automaton `states` [T+1] after each of their labels.

    With a `loop` the steps from there on are repeated for ever.
    """

    observations: npt.NDArray[np.float32]
    states: npt.NDArray[np.int64]
    loop: int | None = None

    def head(self, steps: int) -> Episode:
        """Its first `steps` steps."""
        return Episode(self.observations[: steps + 1], self.states[: steps + 1])


@dataclass(frozen=True)
class View:
    """Where a map's place (x, y) is shown: the map's `bounds` lie in `frame`, y upwards."""

    bounds: tuple[float, float, float, float]
    frame: Box

    @property
    def scale(self) -> float:
        """Pixels a unit of the map."""
        return self.frame.width / (self.bounds[2] - self.bounds[0])

    def at(self, x: float, y: float) -> Point:
        """The pixel of a place."""
        return (
            self.frame.x + (x - self.bounds[0]) * self.scale,
            self.frame.y + (self.bounds[3] - y) * self.scale,
        )


def view_in(drawn: Map, room: Box) -> View:
    """The map as large as it fits into `room`, in its middle."""
    x_min, y_min, x_max, y_max = drawn.bounds
    scale = min(room.width / (x_max - x_min), room.height / (y_max - y_min))
    width, height = (x_max - x_min) * scale, (y_max - y_min) * scale
    left, top = room.x + (room.width - width) / 2, room.y + (room.height - height) / 2
    return View(drawn.bounds, Box(left, top, width, height, Look()))


def on_map(
    drawn: Map, episodes: Sequence[Episode], states: Sequence[State], view: View
) -> list[Shape]:
    """The map, its zones' names, and the paths of episodes over it."""
    frame = view.frame
    ground = Box(frame.x, frame.y, frame.width, frame.height, Look(fill=CARD))
    rim = Box(frame.x, frame.y, frame.width, frame.height, Look(stroke=LINE, width=1.0))
    inside: list[Plain] = list(zones(drawn, view))
    for episode in episodes:
        inside += path(episode, drawn, states, view)
    inside += names(drawn, view, 12.0 if view.frame.width > 200 else 9.0)
    return [ground, Clip(frame, tuple(inside)), rim]


def zones(drawn: Map, view: View) -> Iterator[Plain]:
    """The areas of a map."""
    for shape in drawn.shapes:
        look = Look(shape.color, shape.color if shape.edge else "", 1.0, 0.22, 0.55)
        x, y = view.at(*shape.low)
        if shape.inner:
            yield Ring(x, y, shape.inner * view.scale, shape.radius * view.scale, look)
        elif shape.radius:
            yield Disc(x, y, shape.radius * view.scale, look)
        else:
            right, top = view.at(*shape.high)
            yield Box(x, top, right - x, y - top, look)


def names(drawn: Map, view: View, size: float = 12.0) -> Iterator[Text]:
    """What its areas are called; in a ring the name stands below the hole."""
    named = [shape for shape in drawn.shapes if shape.name]
    middles = []
    for shape in named:
        x, y = view.at((shape.low[0] + shape.high[0]) / 2, (shape.low[1] + shape.high[1]) / 2)
        y += (shape.inner + shape.radius) / 2 * view.scale if shape.inner else 0.0
        middles.append((x, y))
    for shape, (x, y) in zip(named, apart(middles, size), strict=True):
        yield Text(x, y + size / 3, shape.name, size, INK, "middle", True, 0.55)
    if any(drawn.axes):
        frame, (across, up) = view.frame, drawn.axes
        bottom = frame.y + frame.height - 6
        yield Text(frame.x + frame.width - 6, bottom, f"{across} →", size, SOFT, "end")
        yield Text(frame.x + 6, frame.y + size + 4, f"{up} ↑", size, SOFT)


def path(
    episode: Episode, drawn: Map, states: Sequence[State], view: View, width: float = 2.2
) -> Iterator[Plain]:
    """Where an episode went, up to the sink; its start, accepting visits and the end."""
    run = episode.states
    fell = next((t for t, b in enumerate(run) if states[b].kind == "sink"), len(run) - 1)
    places = [view.at(x, y) for x, y in drawn.places(episode.observations).tolist()]
    for start, stop in stretches(run[: fell + 1]):
        color = states[run[start]].color
        points = tuple(places[start : min(stop, fell) + 1])
        if len(points) > 1:
            yield Path(points, Look(stroke=color, width=width, alpha=0.9))
        if fell <= ROUGH:
            yield from (Disc(x, y, 0.8 * width, Look(color)) for x, y in places[start:stop])
    for t, _ in stretches(run[: fell + 1]):  # where it stays accepting, one mark is enough
        if t and states[run[t]].kind == "accepting":
            yield Disc(*places[t], 2.2 * width, Look(states[run[t]].color, PAPER, 1.2))
    if episode.loop is not None and states[run[fell]].kind != "sink":
        around = tuple(places[episode.loop :])
        yield Path((*around, around[0]), Look(stroke=INK, width=0.6 * width))
        yield from (Disc(x, y, 1.6 * width, Look(stroke=INK, width=1.2)) for x, y in around)
    yield Disc(*places[0], 2.0 * width, Look(PAPER, INK, 1.6))
    if states[run[fell]].kind == "sink":
        (x, y), arm = places[fell], 2.2 * width
        for sign in (1, -1):
            ends = ((x - arm, y - sign * arm), (x + arm, y + sign * arm))
            yield Path(ends, Look(stroke=SINK, width=3.0))


def bars(
    run: npt.NDArray[np.int64], states: Sequence[State], room: Box, total: int | None = None
) -> Iterator[Shape]:
    """The states of a run along `total` moments (its own, unless told) as a row of bars."""
    yield Box(room.x, room.y, room.width, room.height, Look(fill=LINE, fill_alpha=0.6))
    scale = room.width / (total or len(run))
    for start, stop in stretches(run):
        wide = max((stop - start) * scale, 0.75)
        look = Look(states[run[start]].color)
        yield Box(room.x + start * scale, room.y, wide, room.height, look)


def photo_in(pixels: Pixels, room: Box) -> Photo:
    """A frame as large as it fits into `room`, in its middle."""
    height, width = pixels.shape[:2]
    scale = min(room.width / width, room.height / height)
    wide, high = width * scale, height * scale
    return Photo(
        room.x + (room.width - wide) / 2, room.y + (room.height - high) / 2, wide, high, pixels
    )


def shows_map(pixels: Pixels, drawn: Map) -> bool:
    """Whether a frame shows the map itself, as the frames of flat worlds do.

    It has the map's proportions, and the zones' colours where the zones are.
    """
    x_min, y_min, x_max, y_max = drawn.bounds
    height, width = pixels.shape[:2]
    if abs(width - height * (x_max - x_min) / (y_max - y_min)) > 1:
        return False
    row, column = np.mgrid[0 : height : max(1, height // 50), 0 : width : max(1, width // 50)]
    x = x_min + (column + 0.5) / width * (x_max - x_min)
    y = y_max - (row + 0.5) / height * (y_max - y_min)
    expected = np.full((*x.shape, 3), -1)
    for shape in drawn.shapes:
        expected[covered(shape, x, y)] = [int(shape.color[i : i + 2], 16) for i in (1, 3, 5)]
    known = expected[..., 0] >= 0
    near = np.abs(expected - pixels[row, column]).max(axis=-1) < 12
    return bool(known.any() and near[known].mean() > 0.7)  # the agent lies over some of it


def covered(
    zone: Zone, x: npt.NDArray[np.floating], y: npt.NDArray[np.floating]
) -> npt.NDArray[np.bool_]:
    """Which of the places (x, y) lie in a zone of the map."""
    away = np.hypot(x - zone.low[0], y - zone.low[1])
    if zone.radius:
        return np.asarray((away < zone.radius) & (away >= zone.inner))
    inside = (x >= zone.low[0]) & (x < zone.high[0])
    return np.asarray(inside & (y >= zone.low[1]) & (y < zone.high[1]))


def stretches(run: npt.NDArray[np.int64]) -> list[tuple[int, int]]:
    """The stretches [start, stop) of equal states."""
    cuts = [0, *(np.flatnonzero(np.diff(run)) + 1).tolist(), len(run)]
    return list(itertools.pairwise(cuts))
