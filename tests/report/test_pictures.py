"""Pictures and films of environments: what is drawn, and the files it is written to."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from tests.report.runs import plan
from tiloilc.demos import bundled, replay
from tiloilc.driver import labeller
from tiloilc.report.maps import Map, map_of
from tiloilc.report.pictures import canvas, pixels_of, png_of, svg_of
from tiloilc.report.pictures.canvas import Box, Canvas, Clip, Disc, Look, Photo, Ring, Text, fitted
from tiloilc.report.pictures.canvas import Path as Line
from tiloilc.report.pictures.environment import (
    Shown,
    environment_picture,
    highlight,
    moments,
    sheet,
)
from tiloilc.report.pictures.film import MOST_FRAMES, Film, gif_of, pictures, shown_steps
from tiloilc.report.pictures.place import Episode, on_map, shows_map, view_in
from tiloilc.report.states import states_of
from tiloilc.tasks.flatworld import FlatWorldEnv
from tiloilc.tasks.scene import rasterise

SVG = "{http://www.w3.org/2000/svg}"
RED, BLUE = Look("#ff0000"), Look("#0000ff")


def drawn(*shapes: canvas.Shape, size: int = 40) -> np.ndarray:
    return pixels_of(Canvas(size, size, "test", shapes))


@pytest.fixture(scope="module")
def cycle() -> Shown:
    """FlatWorld Cycle with its first demonstration."""
    task = plan()
    demos = bundled("flatworld_cycle")
    assert demos is not None
    seen = demos.episodes[0].observations
    run = replay(seen, labeller(task), task.ldba)
    scene = map_of(task.environment.id, {}, Path())
    assert scene is not None
    states = states_of(task, len(task.ldba.names))
    episode = Episode(seen, run.states)
    return Shown("flatworld_cycle", task.goal, "demonstration 0", scene, {}, episode, states)


def test_shapes_cover_the_pixels_that_they_say() -> None:
    pixels = drawn(Box(10, 10, 20, 10, RED))
    assert pixels[15, 20].tolist() == [255, 0, 0]
    assert pixels[15, 9].tolist() == [255, 255, 255]
    assert pixels[20, 20].tolist() == [255, 255, 255]
    assert pixels[10, 10].tolist() == pixels[19, 29].tolist() == [255, 0, 0]


def test_a_ring_has_a_hole_and_a_disc_has_none() -> None:
    for shape, inside in ((Ring(20, 20, 8, 15, RED), 255), (Disc(20, 20, 15, RED), 0)):
        pixels = drawn(shape)
        assert pixels[20, 20, 2] == inside
        assert pixels[20, 9].tolist() == [255, 0, 0]
        assert pixels[2, 2].tolist() == [255, 255, 255]


def test_what_is_clipped_shows_in_its_frame_only() -> None:
    pixels = drawn(Clip(Box(10, 10, 10, 10, Look()), (Disc(20, 20, 15, RED),)))
    assert pixels[15, 15].tolist() == [255, 0, 0]
    assert pixels[25, 25].tolist() == [255, 255, 255]


def test_half_transparent_colours_are_mixed() -> None:
    pixels = drawn(Box(0, 0, 40, 40, RED), Box(0, 0, 40, 40, replace(BLUE, fill_alpha=0.5)))
    assert pixels[20, 20].tolist() == pytest.approx([127, 0, 128], abs=1)


def test_letters_that_the_font_does_not_have_are_spelled_otherwise() -> None:
    for fancy, plain in (("b₀ – 1", "b0 - 1"), ("ε", "eps")):
        same = [drawn(Text(4, 25, text, 12)) for text in (fancy, plain)]
        np.testing.assert_array_equal(*same)
        assert same[0].min() < 100, "something is written"


def test_long_texts_are_cut_to_their_room() -> None:
    assert fitted("short", 12, 100) == "short"
    cut = fitted("G F (a & X F (b & X F (c & X F d)))" * 3, 12, 100)
    assert cut.endswith("…")
    assert len(cut) < 25


def test_svg_and_pixels_have_the_same_shapes(cycle: Shown) -> None:
    picture = environment_picture(cycle)
    root = ElementTree.fromstring(svg_of(picture))
    assert root.get("width") == "720"
    assert len(list(root.iter(f"{SVG}polyline"))) == len(
        [s for c in picture.shapes if isinstance(c, Clip) for s in c.shapes if isinstance(s, Line)]
    )
    texts = [text.text for text in root.iter(f"{SVG}text")]
    assert texts[:2] == ["flatworld_cycle", cycle.goal]
    assert "lost for ever" in texts
    pixels = np.asarray(Image.open(BytesIO(png_of(picture, 1.0))))
    assert pixels.shape[:2] == (round(picture.height), 720)


def test_the_path_has_the_colours_of_the_states_that_are_passed(cycle: Shown) -> None:
    text = svg_of(environment_picture(cycle))
    assert cycle.episode is not None
    passed = {cycle.states[b].color for b in cycle.episode.states.tolist()}
    root = ElementTree.fromstring(text)
    assert {line.get("stroke") for line in root.iter(f"{SVG}polyline")} == passed
    assert len(passed) == 4


def test_pictures_of_equal_values_are_equal_bytes(cycle: Shown) -> None:
    assert svg_of(environment_picture(cycle)) == svg_of(environment_picture(cycle))
    assert png_of(environment_picture(cycle)) == png_of(environment_picture(cycle))


def test_a_path_ends_in_the_sink_with_a_cross(cycle: Shown) -> None:
    assert cycle.drawn is not None
    seen = np.array([[-1, -1], [-0.5, -0.5], [0, 0]], np.float32)
    lost = Episode(seen, np.array([0, 4, 4]))
    view = view_in(cycle.drawn, Box(0, 0, 100, 100, Look()))
    (clip,) = (s for s in on_map(cycle.drawn, [lost], cycle.states, view) if isinstance(s, Clip))
    crosses = [s for s in clip.shapes if isinstance(s, Line) and s.look.stroke == "#cf3a35"]
    assert len(crosses) == 2
    assert crosses[0].points[0][0] < 50, "where it fell, not where it ended"


def test_a_map_is_shown_whole_and_unstretched_in_its_room() -> None:
    wide = Map((0.0, 0.0, 4.0, 1.0), (), (0, 1))
    view = view_in(wide, Box(10, 10, 100, 100, Look()))
    assert (view.frame.width, view.frame.height) == (100, 25)
    assert view.at(0, 0) == (10, view.frame.y + 25)
    assert view.at(4, 1) == (110, view.frame.y)


def test_frames_are_chosen_where_the_state_is_new() -> None:
    states = np.array([0, 0, 1, 1, 2, 0, 1, 2, 2])
    episode = Episode(np.zeros((9, 2), np.float32), states)
    assert moments(episode) == [0, 2, 4, 8]
    assert highlight(episode, {2}) == 4
    assert highlight(episode, {3}) == 8
    alone = Episode(np.zeros((1, 2), np.float32), np.array([0]))
    assert moments(alone) == [0]


def test_a_sheet_shows_every_task_and_says_where_there_is_no_picture(cycle: Shown) -> None:
    bare = replace(cycle, title="bare", drawn=None, episode=None)
    photo = np.full((30, 40, 3), 7, np.uint8)
    both = replace(cycle, title="both", frames={3: photo})
    picture = sheet([cycle, bare, both] * 3, "9 tasks")
    root = ElementTree.fromstring(svg_of(picture))
    texts = [text.text for text in root.iter(f"{SVG}text")]
    assert [texts.count(t) for t in ("flatworld_cycle", "bare", "both")] == [3, 3, 3]
    assert texts.count("no picture here") == 3
    assert sum(isinstance(shape, Photo) for shape in picture.shapes) == 3
    assert pixels_of(picture, 0.5).shape[1] == round(picture.width / 2)


def film(cycle: Shown, frames: dict[int, np.ndarray]) -> Film:
    assert cycle.episode is not None
    return Film("film", cycle.goal, cycle.episode, cycle.states, cycle.drawn, frames, 10.0)


def test_a_film_has_a_picture_a_step_and_they_all_differ(cycle: Shown) -> None:
    assert cycle.episode is not None
    content = Image.open(BytesIO(gif_of(film(cycle, {}))))
    assert content.n_frames == len(cycle.episode.states)  # type: ignore[attr-defined]
    assert content.info["duration"] == 100
    assert content.info["loop"] == 0
    shown = [pixels.tobytes() for pixels in pictures(film(cycle, {}))]
    assert len(set(shown)) == len(shown)


def test_frames_of_the_environment_are_in_the_film_with_the_way_over_them(cycle: Shown) -> None:
    assert cycle.drawn is not None
    assert cycle.episode is not None
    scene = FlatWorldEnv().scene()
    frame = rasterise(scene, (0.0, 0.0))
    assert shows_map(frame, cycle.drawn)
    frames = dict.fromkeys(range(len(cycle.episode.states)), frame)
    *_, last = pictures(film(cycle, frames))
    colors = {tuple(c) for c in last.reshape(-1, 3).tolist()}
    assert tuple(frame[0, 0].tolist()) in colors
    assert (0x95, 0x66, 0xB0) in colors, "the way, where stage 1 was"
    for wide in (100, 160):
        camera = np.full((100, wide, 3), 90, np.uint8)
        assert not shows_map(camera, cycle.drawn)
        *_, last = pictures(film(cycle, dict.fromkeys(frames, camera)))
        assert (last[70:300, 20:400] == 90).all(axis=2).mean() > 0.9, "no map to draw on"


def test_long_episodes_are_shown_in_steps() -> None:
    steps = shown_steps(1000)
    assert len(steps) <= MOST_FRAMES + 1
    assert (steps[0], steps[-1]) == (0, 1000)
    assert shown_steps(0) == [0]


def test_sizes_are_even_for_video(cycle: Shown) -> None:
    for frames in ({}, dict.fromkeys(range(32), np.zeros((55, 301, 3), np.uint8))):
        first = next(pictures(film(cycle, frames)))
        assert first.shape[0] % 2 == first.shape[1] % 2 == 0
