"""An episode as moving pictures: frames, or the map, with the automaton's state over and under."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np

from tiloilc.report.maps import Map
from tiloilc.report.pictures.canvas import (
    CARD,
    PAPER,
    SOFT,
    Box,
    Canvas,
    Clip,
    Look,
    Path,
    Pixels,
    Plain,
    Shape,
    Text,
    fitted,
)
from tiloilc.report.pictures.environment import said
from tiloilc.report.pictures.place import Episode, bars, names, on_map, path, photo_in, view_in
from tiloilc.report.pictures.place import shows_map as is_the_map
from tiloilc.report.pictures.raster import pixels_of
from tiloilc.report.states import State

SIDE = 420.0
"""The longer side of what is shown, in pixels; GIFs of more are large."""

EDGE, HEAD, FOOT = 12.0, 64.0, 30.0

MOST_FRAMES = 250
"""Of a longer episode every second, third, … step is shown."""

COLORS = 128
"""In a frame of a GIF."""


@dataclass(frozen=True, eq=False)
class Film:
    """An episode to be shown: its frames by step (or none: the map is drawn), its `title`, the
    `goal`, and how many of its steps a second has.
    """

    title: str
    goal: str
    episode: Episode
    states: tuple[State, ...]
    drawn: Map | None
    frames: dict[int, Pixels]
    fps: float


def shown_steps(steps: int) -> list[int]:
    """The steps that a film of an episode shows, its last one among them."""
    stride = -(-(steps + 1) // MOST_FRAMES)
    return sorted({*range(0, steps + 1, stride), steps})


def pictures(film: Film) -> Iterator[Pixels]:
    """What is shown, frame by frame; all have the same size, its sides are even."""
    for step in shown_steps(len(film.episode.states) - 1):
        yield pixels_of(_canvas(film, step))


def gif_of(film: Film) -> bytes:
    """The film as a GIF that begins again for ever."""
    from PIL import Image

    drawn = [
        Image.fromarray(pixels).quantize(COLORS, dither=Image.Dither.NONE)
        for pixels in pictures(film)
    ]
    content = BytesIO()
    first, *rest = drawn
    last = [_milliseconds(film)] * len(rest) + [1500]  # the end is looked at
    first.save(content, "GIF", save_all=True, append_images=rest, duration=last, loop=0)
    return content.getvalue()


def write_mp4(film: Film, target: str | os.PathLike[str]) -> None:
    """The film as an MP4 file. Raises ImportError without the package `imageio-ffmpeg`."""
    import imageio_ffmpeg

    drawn = list(pictures(film))
    height, width = drawn[0].shape[:2]
    fps = 1000 / _milliseconds(film)
    writer = imageio_ffmpeg.write_frames(
        os.fspath(target), (width, height), fps=fps, macro_block_size=2
    )
    writer.send(None)
    for pixels in drawn:
        writer.send(np.ascontiguousarray(pixels))
    writer.close()


def _milliseconds(film: Film) -> int:
    """Between two frames. Players show less than 20 ms as 100."""
    steps = shown_steps(len(film.episode.states) - 1)
    stride = steps[1] - steps[0] if len(steps) > 1 else 1
    return max(20, round(100 * stride / film.fps) * 10)


def _canvas(film: Film, step: int) -> Canvas:
    wide, high = _size(film)
    room = Box(EDGE, HEAD, wide, high, Look())
    before = film.episode.head(step)
    run = film.episode.states
    state = film.states[int(run[step])]
    visits = sum(film.states[b].kind == "accepting" for b in run[1 : step + 1].tolist())
    count = f"step {step} of {len(run) - 1}, {visits} accepting visit{'' if visits == 1 else 's'}"
    shapes: list[Shape] = [
        Text(EDGE, 22, fitted(film.title, 14, wide * 0.5), 14, bold=True),
        Text(EDGE + wide, 22, count, 12, SOFT, "end"),
        Box(EDGE, 34, 12, 12, Look(state.color)),
        Text(EDGE + 18, 44.5, fitted(said(state), 12, wide - 18), 12),
        *_shown(film, before, step, room),
        *bars(before.states, film.states, Box(EDGE, HEAD + high + 8, wide, 10, Look()), len(run)),
    ]
    return Canvas(wide + 2 * EDGE, HEAD + high + FOOT, film.title, tuple(shapes))


def _shown(film: Film, before: Episode, step: int, room: Box) -> Iterator[Shape]:
    """The frame; where it is the map, with the way up to now; the map alone without a frame."""
    drawn, pixels = film.drawn, film.frames.get(step)
    yield Box(room.x, room.y, room.width, room.height, Look(CARD))
    if pixels is None:
        assert drawn is not None
        yield from on_map(drawn, [before], film.states, view_in(drawn, room))
        return
    photo = photo_in(pixels, room)
    yield photo
    if drawn is not None and is_the_map(pixels, drawn):
        view = view_in(drawn, Box(photo.x, photo.y, photo.width, photo.height, Look()))
        way = list(path(before, drawn, film.states, view))
        yield Clip(view.frame, (*_halo(way), *way, *names(drawn, view)))


def _halo(way: Iterable[Plain]) -> Iterator[Plain]:
    """White under lines: zones of a frame are as strong as they are."""
    for shape in way:
        if isinstance(shape, Path):
            look = replace(shape.look, stroke=PAPER, width=shape.look.width + 2.5, alpha=0.9)
            yield replace(shape, look=look)


def _size(film: Film) -> tuple[float, float]:
    """The width and height of what is shown, even numbers: video needs them."""
    if film.frames:
        high, wide = next(iter(film.frames.values())).shape[:2]
    else:
        assert film.drawn is not None
        x_min, y_min, x_max, y_max = film.drawn.bounds
        wide, high = x_max - x_min, y_max - y_min
    scale = SIDE / max(wide, high)
    return max(360.0, 2.0 * round(wide * scale / 2)), max(80.0, 2.0 * round(high * scale / 2))
