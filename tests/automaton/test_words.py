"""Membership, emptiness, example words, comparing formulas."""

from __future__ import annotations

import random

import pytest

from tests.strategies import random_formula, random_lasso
from tiloilc.automaton import (
    Cube,
    Edge,
    Ldba,
    accepted_word,
    accepts,
    difference_word,
    guard_text,
    is_empty,
    rejected_word,
    satisfying_word,
    translate,
)
from tiloilc.ltl import Lasso, holds, negation, parse, to_text

ABC = ("a", "b", "c")


def automaton(text: str) -> Ldba:
    parsed = parse(text)
    return translate(parsed.formula, parsed.propositions)


def test_a_run_may_jump_at_any_letter() -> None:
    ldba = automaton("F G y")
    assert accepts(ldba, Lasso((0, 1, 0, 0), (1,)))
    assert not accepts(ldba, Lasso((1, 1), (1, 0)))


def test_membership_takes_an_automaton_written_by_hand() -> None:
    anything = (Cube(0, 0),)
    edges = (
        Edge(0, 0, (Cube(1, 0),)),
        Edge(0, 1, (Cube(1, 1),)),
        Edge(1, 0, anything),
    )
    ldba = Ldba(("a",), ("", ""), frozenset({1}), None, edges)
    assert accepts(ldba, Lasso((), (1, 0)))
    assert not accepts(ldba, Lasso((1, 1), (0,)))


def test_words_found_are_short() -> None:
    assert accepted_word(automaton("a & X b & X X G c")) == Lasso((1, 2), (4,))
    assert accepted_word(automaton("G F (a & X F b)")) == Lasso((), (1, 2))
    assert rejected_word(automaton("F a")) == Lasso((), (0,))
    assert rejected_word(automaton("G !z")) == Lasso((1,), (0,))
    assert accepted_word(automaton("a & !a")) is None
    assert rejected_word(automaton("true")) is None


def test_words_found_are_words_of_the_right_side() -> None:
    generator = random.Random("words")
    for _ in range(300):
        formula = random_formula(generator, ABC, 10)
        ldba = translate(formula, ABC)
        yes, no = accepted_word(ldba), rejected_word(ldba)
        assert yes is None or holds(formula, yes, ABC), to_text(formula)
        assert no is None or not holds(formula, no, ABC), to_text(formula)
        assert (yes is None) == is_empty(ldba) == (satisfying_word(formula, ABC) is None)
        assert (no is None) == (satisfying_word(negation(formula), ABC) is None)


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("G F (a & X F b)", "G F a & G F b"),
        ("F G (a & b)", "F G a & F G b"),
        ("a U b", "b | (a & X (a U b))"),
        ("a M b", "b U (a & b)"),
    ],
)
def test_equivalent_formulas_have_no_word_between_them(left: str, right: str) -> None:
    formulas = [parse(text, ABC).formula for text in (left, right)]
    assert difference_word(formulas[0], formulas[1], ABC) is None
    assert difference_word(formulas[1], formulas[0], ABC) is None


def test_a_difference_is_a_word_of_the_left_only() -> None:
    generator = random.Random("difference")
    found = 0
    for _ in range(200):
        left, right = (random_formula(generator, ABC, 7) for _ in range(2))
        word = difference_word(left, right, ABC)
        if word is not None:
            found += 1
            assert holds(left, word, ABC)
            assert not holds(right, word, ABC)
        else:
            for _ in range(10):
                lasso = random_lasso(generator, ABC)
                assert holds(right, lasso, ABC) or not holds(left, lasso, ABC)
    assert 50 < found < 200


@pytest.mark.parametrize(
    ("text", "guard"),
    [
        ("true", "true"),
        ("a & !b", "a & !b"),
        ("(a | b) & (a | c)", "a | b & c"),
        ("(a | b) & c", "(a | b) & c"),
        ("!a | b", "!a | b"),
        ("a ^ b", "!a & b | a & !b"),
    ],
)
def test_a_guard_is_a_short_formula(text: str, guard: str) -> None:
    ldba = translate(parse(text, ABC).formula, ABC)
    accepting = {e.target: e for e in ldba.outgoing[0]}[min(ldba.accepting)]
    assert guard_text(accepting.guard, ABC) == guard
