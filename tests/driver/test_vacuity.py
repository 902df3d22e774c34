import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strategies import formulas, lassos
from tiloilc.driver.vacuity import irrelevant_parts, replaced
from tiloilc.ltl import Lasso, holds, parse, to_text
from tiloilc.ltl.ast import FALSE, TRUE, Formula

NAMES = ("a", "b", "c")


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("G F (a & X F b) & G !c", []),
        ("F a & F (a | b)", ["F (a | b)"]),
        ("G a & (b U a)", ["b U a"]),
        ("F (a & X F b) & F (b | c)", ["F (b | c)"]),
        ("F G a & G !b", []),
    ],
)
def test_the_largest_parts_that_do_not_matter_are_named(text: str, parts: list[str]) -> None:
    found = [to_text(part) for part in irrelevant_parts(parse(text, NAMES).formula, NAMES)]
    assert found == parts


@settings(max_examples=60)
@given(formulas(NAMES, 6), st.lists(lassos(NAMES), min_size=4, max_size=4))
def test_words_cannot_tell_a_formula_from_one_without_what_does_not_matter(
    formula: Formula, words: list[Lasso]
) -> None:
    for part in irrelevant_parts(formula, NAMES):
        same = [
            all(
                holds(replaced(formula, part, value), word, NAMES) == holds(formula, word, NAMES)
                for word in words
            )
            for value in (FALSE, TRUE)
        ]
        assert any(same), to_text(part)
