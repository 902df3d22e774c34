"""Every pass over formulas keeps their meaning, on random formulas and words."""

import random
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strategies import formulas, lassos, random_formula, random_lasso
from tiloilc.ltl import (
    Lasso,
    after,
    holds,
    negation,
    nnf,
    parse,
    propositions_of,
    simplify,
    subformulas,
    to_text,
    unfold,
)
from tiloilc.ltl.ast import Formula, Next, Not, Until
from tiloilc.ltl.fragments import is_eventual, is_universal
from tiloilc.ltl.rewrite import RULES, Rule
from tiloilc.ltl.rewrite.implication import implies

ABC = ("a", "b", "c")
NAMES = ("a", "F", "GFa", "a b", 'x"\\', "until", "V")
"""Names that look like operators."""


def letter(bits: int) -> frozenset[str]:
    return frozenset(name for bit, name in enumerate(ABC) if bits >> bit & 1)


PASSES: dict[str, Callable[[Formula], Formula]] = {
    "parse(to_text)": lambda f: parse(to_text(f), ABC).formula,
    "parse(to_text with brackets)": lambda f: parse(to_text(f, brackets=True)).formula,
    "nnf": nnf,
    "not negation": lambda f: Not(negation(f)),
    "simplify": simplify,
    "unfold": lambda f: unfold(nnf(f)),
}


@pytest.mark.parametrize("name", PASSES)
@settings(max_examples=150, deadline=None, derandomize=True)
@given(formula=formulas(ABC), word=lassos(ABC))
def test_a_pass_keeps_the_meaning(name: str, formula: Formula, word: Lasso) -> None:
    assert holds(PASSES[name](formula), word, ABC) == holds(formula, word, ABC)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(formula=formulas(ABC), word=lassos(ABC))
def test_progression_is_the_rest_of_the_word(formula: Formula, word: Lasso) -> None:
    left = after(nnf(formula), letter(word.letters[0]))
    assert holds(left, word.suffix(1), ABC) == holds(formula, word, ABC)
    assert holds(left, word.suffix(1), ABC) == holds(Next(left), word, ABC)


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_keeps_the_meaning_wherever_it_applies(rule: Rule) -> None:
    generator = random.Random(3)
    for _ in range(3_000):
        formula = nnf(random_formula(generator, ABC[:2], 10))
        words = [random_lasso(generator, ABC) for _ in range(3)]
        for part in subformulas(formula):
            if (changed := rule(part)) != part:
                for word in words:
                    same = holds(changed, word, ABC) == holds(part, word, ABC)
                    assert same, (to_text(part), to_text(changed), word)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(formula=formulas(NAMES))
def test_text_reads_back_as_the_same_formula(formula: Formula) -> None:
    for text in (to_text(formula), to_text(formula, brackets=True)):
        assert parse(text).formula == formula
        assert parse(text, propositions_of(formula)).formula == formula


@settings(max_examples=300, deadline=None, derandomize=True)
@given(formula=formulas(ABC))
def test_simplifying_twice_changes_nothing_and_makes_nothing_negative(formula: Formula) -> None:
    simple = simplify(formula)
    assert simplify(simple) == simple
    assert nnf(simple) == simple


def test_what_is_called_implied_is_implied() -> None:
    generator = random.Random(4)
    found = 0
    for _ in range(20_000):
        one, other = (nnf(random_formula(generator, ABC[:2], 6)) for _ in range(2))
        if one != other and implies(one, other):
            found += 1
            for _ in range(10):
                word = random_lasso(generator, ABC)
                assert holds(other, word, ABC) >= holds(one, word, ABC), (one, other, word)
    assert found > 1_000


@settings(max_examples=300, deadline=None, derandomize=True)
@given(formula=formulas(ABC, 8), word=lassos(ABC), start=st.integers(0, 8))
def test_time_does_not_change_eventual_and_universal_formulas(
    formula: Formula, word: Lasso, start: int
) -> None:
    normal = nnf(formula)
    now, later = holds(normal, word, ABC), holds(normal, word.suffix(start), ABC)
    assert not is_eventual(normal) or now >= later
    assert not is_universal(normal) or now <= later


def test_the_oracle_notices_a_wrong_pass() -> None:
    generator = random.Random(5)
    wrong = Until(*map(nnf, (parse("a").formula, parse("b").formula)))
    right = parse("a W b").formula
    words = [random_lasso(generator, ABC) for _ in range(500)]
    assert any(holds(wrong, word, ABC) != holds(right, word, ABC) for word in words)
