"""SVG and PNG: everything is there, legible, inside, and nothing lies on anything else."""

from __future__ import annotations

import random
import re
import struct
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import pytest

from tests.automaton.formulas import PAPER
from tests.strategies import random_formula
from tiloilc.automaton import Cube, Edge, Ldba, to_png, to_svg, translate
from tiloilc.automaton.drawing.picture.compose import MOST_LINKS, picture
from tiloilc.automaton.drawing.picture.layout import Arrow, Route, columns_of
from tiloilc.automaton.drawing.picture.shapes import LOOKS, Curve, Rectangle, Scene, Text
from tiloilc.automaton.drawing.text import own_parts, width, wrapped
from tiloilc.diag import CompileError
from tiloilc.diag.text import cells
from tiloilc.ltl import parse, to_text
from tiloilc.plan import stage_plan

SVG = "{http://www.w3.org/2000/svg}"
LONG = (
    "G F (gripper_is_holding_the_red_cube & X F robot_is_at_the_charging_station)"
    " & G !human_is_inside_the_safety_fence_of_the_robot_cell"
)
DENSE = {
    "five goals": " & ".join(f"G F a{i}" for i in range(5)),
    "large guard": "G ((a & b | c & !d | e & f) -> X ((d | e) & (a | !b))) & G F (a & !(e & f))",
    "long names": LONG,
    "two jumps": "F G (a | b) & G F c | F G (b & !d)",
    "odd names": 'F ("a < b" & X F "c & d")',
    "wide names": 'F ("红色" & X F "ロボット")',
    "nothing": "F a & G !a",
    "everything": "true",
}
FORMULAS = {name: known.text for name, known in PAPER.items()} | DENSE


def automaton(text: str) -> Ldba:
    parsed = parse(text)
    return translate(parsed.formula, parsed.propositions)


def scene(ldba: Ldba, title: str | None = None) -> Scene:
    try:
        return picture(ldba, stage_plan(ldba), title)
    except CompileError:  # no accepting state: there are no stages
        return picture(ldba, None, title)


@dataclass(frozen=True)
class Area:
    """A rectangle that something of the picture fills."""

    of: str
    left: float
    top: float
    right: float
    bottom: float

    def meets(self, other: Area) -> bool:
        apart = self.right <= other.left or other.right <= self.left
        return not (apart or self.bottom <= other.top or other.bottom <= self.top)


def areas(scene: Scene) -> Iterator[Area]:
    """The boxes and the lines of text of a picture, but for the text in boxes."""
    for group in scene.groups:
        for shape in group.shapes:
            if isinstance(shape, Rectangle) and shape.role != "paper" and shape.role != "ring":
                ends = shape.x + shape.width, shape.y + shape.height
                yield Area(group.of, shape.x, shape.y, *ends)
            elif isinstance(shape, Text) and not group.of.startswith("state"):
                size = LOOKS[shape.role].size
                wide = width([shape.text], size)
                left = shape.x - wide / 2 if shape.middle else shape.x
                top, bottom = shape.y - 0.75 * size, shape.y + 0.2 * size
                yield Area(group.of, left, top, left + wide, bottom)


def assert_nothing_overlaps(scene: Scene, told: str) -> None:
    for area in areas(scene):
        assert area.left >= 0, told
        assert area.top >= 0, told
        assert area.right <= scene.width, told
        assert area.bottom <= scene.height, told
    for one, other in combinations(areas(scene), 2):
        if one.of != other.of or not one.of.startswith("lost"):  # the sign ⊥ stands in its box
            assert not one.meets(other), f"{told}: {one} and {other}"
    assert_lines_pass_by(scene, told)


def assert_lines_pass_by(scene: Scene, told: str) -> None:
    """No line runs through a box, or through the text at a loop or a loss."""
    hanging = [area for area in areas(scene) if area.of.split(" ")[0] in ("state", "loop", "lost")]
    for group in scene.groups:
        if group.of.split(" ")[0] in ("edge", "jump"):
            for shape in group.shapes:
                if isinstance(shape, Curve):
                    for x, y in Route(shape.points, shape.points[0]).along():
                        for area in hanging:
                            across = area.left + 1 < x < area.right - 1
                            inside = across and area.top + 1 < y < area.bottom - 1
                            assert not inside, f"{told}: {group.of} through {area}"


@pytest.mark.parametrize("name", FORMULAS)
def test_nothing_overlaps_and_nothing_is_cut_off(name: str) -> None:
    text = FORMULAS[name]
    assert_nothing_overlaps(scene(automaton(text), text), text)


def test_nothing_overlaps_in_pictures_of_random_formulas() -> None:
    generator = random.Random("pictures")
    drawn = 0
    for _ in range(500):
        formula = random_formula(generator, ("a", "bee", "see_the_sea"), 9)
        ldba = translate(formula, ("a", "bee", "see_the_sea"))
        if 2 < len(ldba.names) < 12:
            drawn += 1
            assert_nothing_overlaps(scene(ldba, to_text(formula)), to_text(formula))
    assert drawn > 130


@pytest.mark.parametrize("name", FORMULAS)
def test_text_fits_into_its_box(name: str) -> None:
    for group in scene(automaton(FORMULAS[name])).groups:
        if group.of.startswith("state"):
            box = next(shape for shape in group.shapes if isinstance(shape, Rectangle))
            for text in group.shapes:
                if isinstance(text, Text):
                    wide = width([text.text], LOOKS[text.role].size)
                    assert box.x < text.x - wide / 2
                    assert text.x + wide / 2 < box.x + box.width
                    assert box.y < text.y - LOOKS[text.role].size
                    assert text.y < box.y + box.height


@pytest.mark.parametrize("name", FORMULAS)
def test_svg_is_well_formed_and_tells_everything(name: str) -> None:
    ldba = automaton(FORMULAS[name])
    text = to_svg(ldba, title=FORMULAS[name])
    assert text == to_svg(ldba, title=FORMULAS[name])
    root = ET.fromstring(text)
    assert root.get("role") == "img"
    named, described = root.find(f"{SVG}title"), root.find(f"{SVG}desc")
    assert named is not None
    assert described is not None
    assert named.text == f"Automaton of {FORMULAS[name]}"
    live = [b for b in ldba.states if b != ldba.sink]
    for b in live:
        assert described.text is not None
        assert f"State {b}" in described.text
        assert root.findall(f".//{SVG}g[@data-state='{b}']")
    for b in range(len(ldba.jumps)):
        assert root.findall(f".//{SVG}g[@data-jump='{b}']")
    for index, edge in enumerate(ldba.edges):
        if edge.source != edge.target and ldba.sink not in (edge.source, edge.target):
            assert root.findall(f".//{SVG}g[@data-edge='{index}']")


def test_a_picture_has_no_ids_no_scripts_and_fetches_nothing() -> None:
    text = to_svg(automaton(PAPER["tray"].text))
    assert not re.search(r"\sid=|<script|href|url\(|@import|\son\w+=", text)


def test_stages_go_from_left_to_right() -> None:
    ldba = automaton(PAPER["sixteen_rooms"].text)
    stages = stage_plan(ldba)
    found: dict[int, list[tuple[float, float]]] = {}
    for group in picture(ldba, stages).groups:
        kind, _, number = group.of.partition(" ")
        if kind == "state":
            box = next(shape for shape in group.shapes if isinstance(shape, Rectangle))
            span = (box.x, box.x + box.width)
            found.setdefault(stages.index[int(number)], []).append(span)
    for stage in range(max(found)):
        before = max(right for _, right in found[stage])
        assert before < min(left for left, _ in found[stage + 1])


def test_states_of_one_stage_with_an_edge_stand_in_two_cells() -> None:
    arrows = [Arrow(0, 1, 1, 1), Arrow(2, 1, 1, 1), Arrow(1, 3, 1, 1)]
    assert columns_of([0, 1, 1, 2], arrows) == [0, 1, 2, 3]
    assert columns_of([0, 1, 1, 2], arrows[:1]) == [0, 1, 1, 2]


def test_accepting_states_have_two_lines_and_jumps_are_dashed() -> None:
    drawn = scene(automaton("F G y & G !b"))
    roles = {group.of: {shape.role for shape in group.shapes} for group in drawn.groups}
    assert "ring" in roles["state 1"]
    assert "ring" not in roles["state 0"]
    assert LOOKS["jump"].dash
    lines = [g for g in drawn.groups if g.of == "jump 0"]
    assert any(shape.role == "jump" for group in lines for shape in group.shapes)
    assert any(isinstance(shape, Curve) for shape in lines[0].shapes)


def test_accepting_edges_are_marked() -> None:
    parsed = parse("G F (a & X F b)")
    ldba = translate(parsed.formula, parsed.propositions, acceptance="edge")
    texts = [s.text for g in picture(ldba).groups for s in g.shapes if isinstance(s, Text)]
    assert "● b" in texts
    assert any("accepting edge" in text for text in texts)


def test_what_all_states_ask_is_not_repeated_in_each() -> None:
    ldba = automaton("G F (a & X F (b & X F c)) & G !z")
    assert own_parts(ldba, "G F (a & X F (b & X F c)) & G !z")[:4] == [
        "",
        "F (b & X F c)",
        "F c",
        "",
    ]
    assert own_parts(automaton("F G y & G !b"))[:2] == ["F G y", "G y"]
    assert own_parts(automaton("G !b"))[0] == "G !b"


def test_names_that_are_no_formulas_are_shown_as_they_are() -> None:
    loop = (Cube(0, 0),)
    ldba = Ldba(
        ("a",), ("the (first", "last"), frozenset({1}), None, (Edge(0, 1, loop), Edge(1, 1, loop))
    )
    assert own_parts(ldba) == ["the (first", "last"]
    assert "the (first" in to_svg(ldba)


def test_formulas_are_broken_outside_brackets_first() -> None:
    text = "(a | b & c) & (d | e) & G (f -> X g)"
    assert wrapped(text, 22, 4) == ["(a | b & c) & (d | e)", "& G (f -> X g)"]
    assert wrapped("aa & bb | cc & dd", 10, 4) == ["aa & bb", "| cc & dd"]
    assert wrapped(text, 8, 2) == ["(a", "| b & c) …"]
    assert wrapped("human_is_inside_the_fence", 16, 4) == ["human_is_inside_", "the_fence"]
    assert cells(wrapped("x" * 80, 20, 4)[0]) <= 30


def test_wide_letters_count_twice() -> None:
    assert cells("ab") == 2
    assert cells("红色") == 4
    assert cells("e\u0301") == 1


def test_png_is_as_large_as_the_svg_at_two_dots_a_point() -> None:
    ldba = automaton(PAPER["circular_3"].text)
    data = to_png(ldba, stage_plan(ldba), PAPER["circular_3"].text)
    assert data.startswith(b"\x89PNG")
    wide, high = struct.unpack(">II", data[16:24])
    drawn = picture(ldba, stage_plan(ldba), PAPER["circular_3"].text)
    assert (wide, high) == (
        pytest.approx(2 * drawn.width, abs=3),
        pytest.approx(2 * drawn.height, abs=3),
    )


def test_png_says_nothing_on_standard_error(capfd: pytest.CaptureFixture[str]) -> None:
    to_png(automaton(LONG), title=LONG)
    to_png(automaton(DENSE["odd names"]), title=DENSE["odd names"])
    assert capfd.readouterr().err == ""


def test_an_automaton_that_is_too_large_has_a_picture_that_says_so() -> None:
    letters = [Cube(7, letter) for letter in range(8)]
    edges = [
        Edge(b, (b + 5 * k + 1) % 60, (cube,)) for b in range(60) for k, cube in enumerate(letters)
    ]
    assert len(edges) > MOST_LINKS
    names = tuple(f"state {b}" for b in range(60))
    ldba = Ldba(("a", "b", "c"), names, frozenset({59}), None, tuple(edges))
    text = to_svg(ldba, title="G F a")
    assert "not drawn: it has 60 states and 480 edges" in text
    assert len(ET.fromstring(text).findall(f".//{SVG}rect")) == 2
