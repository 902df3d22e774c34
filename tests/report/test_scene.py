"""The map of a task as shapes of a page."""

from pathlib import Path

import pytest

from tiloilc.report.maps import Map, Shape, map_of
from tiloilc.report.scene import outlines


def test_a_scene_of_the_bundled_tasks_is_read_whole() -> None:
    drawn = map_of("tiloilc/Carlo-v0", {}, Path())
    assert drawn is not None
    assert drawn.bounds == (0, 0, 1, 1)
    names = [shape.name for shape in drawn.shapes]
    assert names == ["wp0", "wp1", "crash", ""]
    ring = drawn.shapes[-1]
    assert ring.low == ring.high == (0.5, 0.5)
    assert (ring.radius, ring.inner) == (0.5, pytest.approx(27.5 / 60))


def test_names_give_way_to_names_alone() -> None:
    near = Shape("a", "#ff0000", (0.0, 0.0), (1.0, 1.0))
    over = [Shape("", "#ff0000", (0.0, 0.0), (1.0, 1.0))] * 9
    (*_, alone) = outlines(Map((0, 0, 1, 1), (near,), (0, 1)), 0, 1, 10)
    (*_, among) = outlines(Map((0, 0, 1, 1), (near, *over), (0, 1)), 0, 1, 10)
    assert "<text" in alone
    assert alone == among


def test_what_has_no_name_is_drawn_without_one() -> None:
    wall = Shape("", "#ff0000", (0.0, 0.0), (1.0, 1.0))
    (area,) = outlines(Map((0, 0, 1, 1), (wall,), (0, 1)), 0, 1, 10)
    assert "<rect" in area
    assert "<title" not in area
