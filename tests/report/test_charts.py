"""Elements escape, axes are round, and lines are where their numbers are."""

import itertools
import re

import numpy as np
import pytest

from tiloilc.evaluate import Band, summarise
from tiloilc.evaluate.statistics import generator
from tiloilc.report.charts import Area, Level, Series, area_chart, line_chart, strip
from tiloilc.report.frame import short, ticks
from tiloilc.report.markup import Markup, concat, number, tag
from tiloilc.report.states import LIVE, palette, subscript


def test_children_and_attributes_are_escaped_unless_they_are_markup() -> None:
    assert tag("p", "a < b & c", title='"x"') == '<p title="&quot;x&quot;">a &lt; b &amp; c</p>'
    assert tag("p", tag("b", "x"), ["<", Markup("<br>")]) == "<p><b>x</b>&lt;<br></p>"
    assert concat("<", [">"]) == "&lt;&gt;"


def test_attributes_without_a_value_are_left_out() -> None:
    assert (
        tag("div", class_="a", hidden=True, id=None, open=False) == '<div class="a" hidden></div>'
    )
    assert tag("meta", name="x", http_equiv="y") == '<meta name="x" http-equiv="y">'


@pytest.mark.parametrize(
    ("value", "shown"), [(1.0, "1"), (0.125, "0.12"), (-0.001, "0"), (2.5, "2.5"), (100, "100")]
)
def test_numbers_have_one_way_to_be_written(value: float, shown: str) -> None:
    assert number(value) == shown


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0, 4, [0, 1, 2, 3, 4]),
        (0, 1, [0, 0.25, 0.5, 0.75, 1]),
        (0, 3.3, [0, 1, 2, 3, 4]),
        (0, 0, [0, 0.25, 0.5, 0.75, 1.0]),
        (-7, 12, [-10, -5, 0, 5, 10, 15]),
    ],
)
def test_ticks_are_round_and_span_the_values(
    low: float, high: float, expected: list[float]
) -> None:
    assert ticks(low, high, 4) == pytest.approx(expected)


def test_steps_are_written_short() -> None:
    assert [short(v) for v in (0, 500, 2500, 60_000, 1_500_000)] == [
        "0", "500", "2.5k", "60k", "1.5M"
    ]  # fmt: skip


def series(seeds: np.ndarray) -> Series:
    mean = seeds.mean(axis=1)
    names = tuple(f"seed {i}" for i in range(seeds.shape[1]))
    return Series("run", "run-0", (0, 50, 100), Band(mean, mean - 0.5, mean + 0.5), seeds, names)


def chart(**changes: object) -> str:
    one = series(np.array([[0.0, 0.0], [1.0, 3.0], [4.0, 4.0]]))
    given = {"title": "t", "unit": "u", "width": 374.0, "height": 272.0, "labels": False}
    return line_chart([one], [Level("optimum", "optimum", 4.0)], **{**given, **changes})  # type: ignore[arg-type]


def test_a_curve_runs_from_corner_to_corner() -> None:
    # the plot is 46 to 358 across and 28 to 228 down: 0 is at the bottom left, 4 at the top right
    mean = re.search(r'class="mean" d="([^"]*)"', chart())
    assert mean is not None
    assert mean[1] == "M46,228L202,128L358,28"


def test_a_level_is_as_high_as_its_value() -> None:
    assert 'class="level optimum" x1="46" x2="358" y1="28" y2="28"' in chart()


def test_every_seed_has_its_line_and_name() -> None:
    lines = re.findall(r'class="seed" d="([^"]*)"><title>([^<]*)</title>', chart())
    assert lines == [
        ("M46,228L202,178L358,28", "run, seed 0"),
        ("M46,228L202,78L358,28", "run, seed 1"),
    ]


def test_gaps_in_a_curve_are_skipped() -> None:
    one = series(np.array([[0.0, 0.0], [np.nan, np.nan], [4.0, 4.0]]))
    drawn = line_chart([one], title="t", unit="u", width=374, height=272, labels=False)
    assert 'class="mean" d="M46,228L342' not in drawn
    assert "nan" not in drawn


def test_level_names_never_lie_on_each_other() -> None:
    levels = [Level("a", "x", 3.0), Level("b", "y", 3.01), Level("c", "z", 2.99)]
    one = series(np.array([[0.0, 0.0], [1.0, 3.0], [4.0, 4.0]]))
    drawn = line_chart([one], levels, title="t", unit="u", width=600, height=300)
    heights = [float(y) for y in re.findall(r'class="level-name [^>]* y="([\d.]+)"', drawn)]
    assert len(heights) == 3
    assert all(b - a >= 15 for a, b in itertools.pairwise(heights))


def test_areas_are_stacked_to_the_top() -> None:
    halves = [Area("a", "b₀", "#111111", np.array([0.5, 0.25])),
              Area("b", "b₁", "#222222", np.array([0.5, 0.75]))]  # fmt: skip
    drawn = area_chart([50, 100], halves, title="t", width=380, height=272)
    paths = re.findall(r'<path d="([^"]*)" fill="(#\d+)"', drawn)
    assert paths[0] == ("M46,128L196,128L346,178L346,228L196,228L46,228Z", "#111111")
    assert paths[1] == ("M46,28L196,28L346,28L346,178L196,128L46,128Z", "#222222")


def test_ten_equal_seeds_stay_in_their_strip() -> None:
    values = np.full(10, 2.0)
    summary = summarise(values, generator())
    assert summary is not None
    names = [f"seed {i}" for i in range(10)]
    drawn = strip(values, names, summary, 0.0, 4.0, number)
    heights = [float(y) for y in re.findall(r'cy="([-\d.]+)"', drawn)]
    assert len(set(heights)) == 10
    assert all(2.5 <= y <= 31.5 for y in heights)


def test_few_states_get_fixed_colours_and_many_get_different_ones() -> None:
    assert palette(3) == list(LIVE[:3])
    assert len(set(palette(20))) == 20


def test_numbers_below_the_line() -> None:
    assert subscript(10) == "₁₀"
