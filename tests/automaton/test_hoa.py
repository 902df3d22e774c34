"""HOA out: what an independent reader makes of it."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.automaton.formulas import PAPER
from tests.automaton.hoa_reader import read_hoa
from tests.strategies import random_formula, random_lasso
from tiloilc.automaton import Acceptance, Cube, Edge, Ldba, from_hoa, to_hoa, translate
from tiloilc.ltl import holds, parse, to_text

GOLDEN = Path(__file__).parents[1] / "golden" / "hoa"


def automaton(text: str, acceptance: Acceptance = "state") -> Ldba:
    parsed = parse(text)
    return translate(parsed.formula, parsed.propositions, acceptance=acceptance)


@pytest.mark.parametrize("name", PAPER)
def test_the_papers_formulas_give_the_golden_text(name: str) -> None:
    formula = PAPER[name].text
    text = to_hoa(automaton(formula), name=formula)
    assert text == (GOLDEN / f"{name}.hoa").read_text(encoding="utf-8")
    read_hoa(text)


@pytest.mark.parametrize("acceptance", ["state", "edge"])
@pytest.mark.parametrize("complete", [True, False])
def test_the_text_read_back_has_the_formulas_language(
    acceptance: Acceptance, complete: bool
) -> None:
    generator = random.Random(f"hoa {acceptance} {complete}")
    propositions = ("a", "b", "c")
    for _ in range(250):
        formula = random_formula(generator, propositions, 10)
        ldba = translate(formula, propositions)
        hoa = read_hoa(to_hoa(ldba, acceptance=acceptance, complete=complete))
        for _ in range(4):
            lasso = random_lasso(generator, propositions, 3, 3)
            expected = holds(formula, lasso, propositions)
            assert hoa.accepts(lasso) == expected, f"{to_text(formula)} on {lasso}"


def test_an_automaton_with_marked_edges_is_written_as_such() -> None:
    hoa = read_hoa(to_hoa(automaton("G F (a & X F b)", acceptance="edge")))
    assert "trans-acc" in hoa.headers["properties"]
    assert len(hoa.edges) == 2


def test_accepting_states_can_be_written_on_edges_with_fewer_states() -> None:
    ldba = automaton("G F (a & X F b)")
    assert len(read_hoa(to_hoa(ldba)).edges) == 3
    assert len(read_hoa(to_hoa(ldba, acceptance="edge")).edges) == 2


def test_a_jump_becomes_ordinary_edges_of_its_source() -> None:
    hoa = read_hoa(to_hoa(automaton("F G y & G !b")))
    good = 0b01
    assert sorted(target for guard, target, _ in hoa.edges[0] if good in guard) == [0, 1]


def test_without_completion_the_sink_is_left_out() -> None:
    ldba = automaton("F a & G !z")
    assert len(read_hoa(to_hoa(ldba, complete=True)).edges) == 3
    assert len(read_hoa(to_hoa(ldba, complete=False)).edges) == 2


def test_a_sink_that_every_jump_avoids_is_left_out() -> None:
    b, other = (Cube(1, 1),), (Cube(1, 0),)
    every = (Cube(0, 0),)
    edges = (Edge(0, 0, b), Edge(0, 2, other), Edge(1, 1, every), Edge(2, 2, every))
    ldba = Ldba(("b",), ("wait", "go", "false"), frozenset({1}), 2, edges, ((0, 1),))
    text = to_hoa(ldba)
    assert len(read_hoa(text).edges) == 2
    assert to_hoa(from_hoa(text)) == text


def test_the_empty_automaton_keeps_its_one_state() -> None:
    hoa = read_hoa(to_hoa(automaton("a & !a"), complete=False))
    assert sorted(hoa.edges) == [0]
    assert not hoa.state_marks


def test_names_with_quotes_are_escaped() -> None:
    parsed = parse('F "odd name" & G !b')
    ldba = translate(parsed.formula, parsed.propositions)
    assert read_hoa(to_hoa(ldba, name='a "b" \\ c')).propositions == ("odd name", "b")


def test_guards_are_cubes_and_not_lists_of_letters() -> None:
    parsed = parse("F (a | b | c | d | e | f | g | h)")
    text = to_hoa(translate(parsed.formula, parsed.propositions))
    assert "[!0&!1&!2&!3&!4&!5&!6&!7] 0" in text
    assert len(text) < 700
