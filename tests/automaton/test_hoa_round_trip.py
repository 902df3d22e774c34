"""What is written as HOA is read back: the same automaton, the same bytes when written again."""

from __future__ import annotations

import random
from itertools import product
from pathlib import Path

import pytest

from tests.automaton.formulas import PAPER
from tests.automaton.hoa_reader import read_hoa as read_strictly
from tests.strategies import random_formula, random_lasso
from tiloilc.automaton import Acceptance, Ldba, accepts, from_hoa, to_hoa, translate
from tiloilc.ltl import holds, parse, to_text
from tiloilc.ltl.ast import Formula

GOLDEN = sorted((Path(__file__).parents[1] / "golden" / "hoa").glob("*.hoa"))
FORMS: tuple[tuple[Acceptance, bool], ...] = tuple(product(("state", "edge"), (True, False)))
ABC = ("a", "b", "c")


@pytest.mark.parametrize("name", PAPER)
@pytest.mark.parametrize(("acceptance", "complete"), FORMS)
def test_the_papers_automata_come_back_byte_by_byte(
    name: str, acceptance: Acceptance, complete: bool
) -> None:
    parsed = parse(PAPER[name].text)
    ldba = translate(parsed.formula, parsed.propositions, acceptance=acceptance)
    text = to_hoa(ldba, complete=complete, acceptance=acceptance)
    back = from_hoa(text, acceptance=acceptance)
    assert len(back.names) == len(ldba.names)
    assert back.names == ldba.names
    assert to_hoa(back, complete=complete, acceptance=acceptance) == text


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
def test_golden_files_come_back_byte_by_byte(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert to_hoa(from_hoa(text), name=PAPER[path.stem].text) == text


def test_random_automata_come_back_byte_by_byte_with_their_language() -> None:
    round_trips(random.Random("round trip"), 250)


@pytest.mark.slow
def test_many_random_automata_come_back_byte_by_byte_with_their_language() -> None:
    round_trips(random.Random("many round trips"), 4_000)


def round_trips(generator: random.Random, count: int) -> None:
    jumping = 0
    for _ in range(count):
        formula = random_formula(generator, ABC, 12)
        for acceptance, complete in FORMS:
            ldba = translate(formula, ABC, acceptance=acceptance)
            text = to_hoa(ldba, complete=complete, acceptance=acceptance)
            back = from_hoa(text, acceptance=acceptance)
            assert to_hoa(back, complete=complete, acceptance=acceptance) == text, to_text(formula)
            assert len(back.names) <= len(ldba.names)
            jumping += bool(back.jumps)
        check_words(generator, formula, back, text)
    assert jumping > count // 50


def check_words(generator: random.Random, formula: Formula, back: Ldba, text: str) -> None:
    """Our reader and the strict one find the formula's words."""
    strict = read_strictly(text)
    for _ in range(4):
        lasso = random_lasso(generator, ABC, 3, 3)
        expected = holds(formula, lasso, ABC)
        assert accepts(back, lasso) == expected, f"{to_text(formula)} on {lasso}"
        assert strict.accepts(lasso) == expected


@pytest.mark.parametrize("acceptance", ["state", "edge"])
def test_marks_can_be_moved_between_states_and_edges_while_reading(acceptance: Acceptance) -> None:
    generator = random.Random(f"moved {acceptance}")
    other: Acceptance = "edge" if acceptance == "state" else "state"
    for _ in range(150):
        formula = random_formula(generator, ABC, 9)
        text = to_hoa(translate(formula, ABC, acceptance=other), acceptance=other)
        back = from_hoa(text, acceptance=acceptance)
        for _ in range(4):
            lasso = random_lasso(generator, ABC, 3, 3)
            assert accepts(back, lasso) == holds(formula, lasso, ABC), text


def test_reading_what_was_read_and_written_changes_nothing_more() -> None:
    from tests.automaton.hoa_random import random_automaton

    generator = random.Random("again")
    for _ in range(200):
        ldba = from_hoa(random_automaton(generator)[1])
        once = from_hoa(to_hoa(ldba))
        twice = from_hoa(to_hoa(once))
        assert len(once.names) <= len(ldba.names)
        assert to_hoa(once) == to_hoa(twice)


def test_of_two_jumps_that_give_as_much_the_one_that_can_be_waited_for_is_found() -> None:
    formula = parse("(X (c | X a) <-> F c) M !b").formula
    text = to_hoa(translate(formula, ABC, acceptance="edge"), acceptance="edge")
    assert to_hoa(from_hoa(text, acceptance="edge"), acceptance="edge") == text
