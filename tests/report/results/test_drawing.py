"""Curves as files: where their numbers are, both colourings, and how large they get."""

import re
from xml.etree import ElementTree

import numpy as np

from tiloilc.evaluate import Band
from tiloilc.report.results.drawing import HEIGHT, WIDTH, Line, Panel, picture
from tiloilc.report.results.methods import METHODS


def line(name: str, points: int = 3, level: float = 4.0) -> Line:
    values = np.linspace(0, level, points)
    label, ink = METHODS[name]
    return Line(label, ink, [1000 * (i + 1) for i in range(points)], Band(values, values, values))


def test_a_curve_is_where_its_numbers_are() -> None:
    drawn = picture([Panel("Title", "unit", [line("tiloil")])], 1, "all")
    (path,) = re.findall(r'class="line c0" d="M([^"]*L[^"]*)"', drawn)
    (x0, y0), _, (x2, y2) = (tuple(map(float, p.split(","))) for p in path.split("L"))
    assert x2 == WIDTH - 24
    assert y2 == 52  # the top of the axes is 4
    assert y0 == HEIGHT - 44
    assert (x0 - 46) * 3 == x2 - 46


def test_it_is_xml_with_both_colourings_and_a_name() -> None:
    panel = Panel("A < B", "unit", [line("tiloil"), line("lcer")], ("best", 5.0))
    drawn = picture([panel], 1, "what & who")
    root = ElementTree.fromstring(drawn)
    assert root.findtext("{http://www.w3.org/2000/svg}title") == "what & who"
    light, dark = drawn.split("@media (prefers-color-scheme:dark)")
    for name in ("tiloil", "lcer"):
        ink = METHODS[name][1]
        assert ink.light in light
        assert ink.dark in dark
    assert "A &lt; B" in drawn


def test_the_legend_names_each_method_once_for_all_panels() -> None:
    panels = [
        Panel("one", "u", [line("tiloil")]),
        Panel("two", "u", [line("tiloil"), line("gail")]),
    ]
    drawn = picture(panels, 2, "t")
    assert drawn.count(">TiLoIL</text>") == drawn.count(">GAIL</text>") == 1
    assert ElementTree.fromstring(drawn).get("width") == f"{2 * WIDTH:g}"


def test_every_method_has_its_own_look() -> None:
    for ground in ("light", "dark"):
        colors = {getattr(ink, ground) for _, ink in METHODS.values()}
        assert len(colors) == len(METHODS)


def test_four_panels_of_all_methods_with_long_curves_stay_small() -> None:
    lines = [line(name, 1000, 3.3) for name in METHODS]
    panels = [Panel("title", "unit", lines, ("best", 4.0)) for _ in range(4)]
    assert len(picture(panels, 2, "t").encode()) < 60_000
