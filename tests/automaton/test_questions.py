"""Yes-or-no questions about formulas: right where they are answered, given up at the same point."""

import random
from itertools import count

import pytest

from tests.strategies import random_formula
from tiloilc.automaton import satisfying_word, translate
from tiloilc.automaton.language.classes import hierarchy_class
from tiloilc.automaton.language.compare import irrelevant_propositions
from tiloilc.automaton.language.questions import implies, is_satisfiable, small_budget
from tiloilc.automaton.language.shortest import shortest_word
from tiloilc.automaton.limits import Budget
from tiloilc.diag import CompileError
from tiloilc.driver.vacuity import irrelevant_parts
from tiloilc.ltl import Lasso, parse, to_text
from tiloilc.ltl.hierarchy import Hierarchy

NAMES = ("a", "b", "c")


def test_a_formula_is_satisfiable_where_its_automaton_has_a_word() -> None:
    generator = random.Random(12)
    answers = set()
    for _ in range(400):
        formula = random_formula(generator, NAMES, 10)
        answer = is_satisfiable(formula, NAMES, small_budget())
        assert answer == (satisfying_word(formula, NAMES) is not None), to_text(formula)
        answers.add(answer)
    assert answers == {True, False}


@pytest.mark.parametrize(
    ("left", "right", "wanted"),
    [
        ("G F (a & X F b)", "G F a & G F b", True),
        ("G F a", "F a", True),
        ("F a", "G F a", False),
        ("F G a", "G F a", True),
        ("a U b", "F b", True),
        ("a W b", "F b", False),
    ],
)
def test_one_formula_implies_another_if_all_its_words_are_words_of_it(
    left: str, right: str, wanted: bool
) -> None:
    formulas = parse(left).formula, parse(right).formula
    assert implies(*formulas, NAMES, small_budget()) is wanted


def test_a_question_that_takes_too_much_work_ends_in_a_clear_error() -> None:
    formula = parse("G F a & F (b & X F c)").formula
    with pytest.raises(CompileError, match="more work than was allowed"):
        is_satisfiable(formula, NAMES, Budget.of_work(200, 20))
    with pytest.raises(CompileError, match="more than 2 states"):
        is_satisfiable(formula, NAMES, Budget.of_work(2, 50_000))
    with pytest.raises(CompileError, match=r"more than 1 state$"):
        is_satisfiable(formula, NAMES, Budget.of_work(1, 50_000))


def test_what_is_found_does_not_depend_on_how_fast_the_machine_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = "F (a & X F b) & F (b | c) & (G F d | F G !d | e)"
    parsed = parse(text)
    formula, names = parsed.formula, parsed.propositions
    known, ldba = satisfying_word(formula, names), translate(formula, names)
    assert known is not None
    hours = count(step=3600)
    monkeypatch.setattr("tiloilc.automaton.limits.time.monotonic", lambda: next(hours))
    parts = irrelevant_parts(parsed.syntax, names)
    assert [text[p.start : p.end] for p, _ in parts] == ["F (b | c)", "(G F d | F G !d | e)"]
    assert list(irrelevant_propositions(formula, names)) == ["c", "d", "e"]
    assert shortest_word(formula, names, known) == Lasso((), (3,))
    assert hierarchy_class(ldba) is Hierarchy.GUARANTEE
