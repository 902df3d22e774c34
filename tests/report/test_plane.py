"""The plane of two observed numbers as a map."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.report.runs import plan
from tiloilc.plan import Predicate
from tiloilc.report.pictures.place import covered
from tiloilc.report.plane import plane_of

SEEN = np.array([[0.0, -0.02], [2.0, 0.02], [4.0, 0.01]], np.float32)


def task(*predicates: tuple[str, str]):
    return replace(
        plan(),
        fields={"far": (0, 1), "fast": (1, 2), "both": (0, 2)},
        predicates=tuple(Predicate(name, text) for name, text in predicates),
    )


def test_zones_are_where_propositions_hold_whatever_the_units() -> None:
    made = task(("a", "far > 3"), ("b", "hypot((far - 2) / 4, fast / 0.05) < 0.3"))
    drawn = plane_of(made, Path(), SEEN)
    assert drawn is not None
    assert drawn.axes == ("far", "fast")
    (a,) = (shape for shape in drawn.shapes if shape.name == "a")
    assert a.edge
    pieces = [shape for shape in drawn.shapes if shape.color != a.color]
    assert len(pieces) > 5
    assert [piece.name for piece in pieces].count("b") == 1
    assert not any(piece.edge for piece in pieces)
    generator = np.random.default_rng(0)
    places = generator.uniform([-0.3, -0.023], [4.3, 0.023], (500, 2))
    x, y = drawn.places(places).T
    inside = np.any([covered(piece, x, y) for piece in pieces], axis=0)
    holds = np.hypot((places[:, 0] - 2) / 4, places[:, 1] / 0.05) < 0.3
    assert (inside == holds).mean() > 0.97, "but for half a cell along the rim"
    assert (covered(a, x, y) == (places[:, 0] > 3)).mean() > 0.98


def test_both_axes_are_as_long_and_all_that_was_seen_is_on_it() -> None:
    drawn = plane_of(task(("a", "far > 3")), Path(), SEEN)
    assert drawn is not None
    x_min, y_min, x_max, y_max = drawn.bounds
    assert (x_max - x_min, y_max - y_min) == (pytest.approx(1), pytest.approx(1))
    x, y = drawn.places(SEEN).T
    assert x_min < x.min() < x.max() < x_max
    assert y_min < y.min() < y.max() < y_max


def test_there_is_no_plane_of_more_numbers_or_of_a_line_or_where_nothing_can_be_asked() -> None:
    made = task(("a", "far > 3"))
    assert plane_of(made, Path(), np.zeros((5, 3), np.float32)) is None
    assert plane_of(made, Path(), SEEN * np.array([1, 0], np.float32)) is None
    assert plane_of(made, Path(), SEEN[:1]) is None
    gone = replace(made, predicates=(Predicate("a", python="gone.py:a"),))
    assert plane_of(gone, Path(), SEEN) is None
