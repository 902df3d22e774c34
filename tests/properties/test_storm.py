"""Storm and our automata agree; wrong automata, and automata that guess too early, do not."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import pytest

from tests.properties.models import Choice, Mdp, best_probability, buchi_probability
from tests.properties.storm import (
    ABC,
    TOLERANCE,
    Pair,
    compare,
    compared,
    random_pair,
    storm_probability,
)
from tests.strategies import random_formula, random_lasso
from tiloilc.automaton import Cube, Edge, Ldba, accepts, translate
from tiloilc.ltl import holds, parse, to_text
from tiloilc.ltl.ast import Formula

EVERY = (Cube(0, 0),)
SURE = Fraction(1)
HALF = Fraction(1, 2)


@pytest.mark.parametrize(
    ("patterns", "count", "jumping", "between"),
    [(False, 250, 10, 8), (True, 100, 50, 2)],
    ids=["random", "jumping"],
)
def test_a_few_hundred_pairs_have_the_probability_that_storm_says(
    patterns: bool, count: int, jumping: int, between: int
) -> None:
    series = compare(count, 1, patterns)
    assert [verdict.text for verdict in series.wrong] == []
    assert series.jumping > jumping, "the pairs are of the kind they should be"
    assert series.between > between, "and not all are sure"
    assert series.silent < 10


@pytest.mark.slow
@pytest.mark.parametrize("patterns", [False, True], ids=["random", "jumping"])
def test_two_thousand_pairs_have_the_probability_that_storm_says(patterns: bool) -> None:
    series = compare(2_000, 2, patterns)
    assert [verdict.text for verdict in series.wrong] == []


def test_the_first_letter_is_the_label_of_the_initial_state() -> None:
    mdp = Mdp((1, 2), (({1: SURE},), ({1: SURE},)))
    for text, expected in (("a", 1), ("b", 0), ("X b", 1), ("X a", 0), ("a & X G b", 1)):
        verdict = compared(Pair(0, parse(text).formula, mdp))
        assert verdict is not None
        assert (verdict.storm, verdict.difference) == (expected, 0), text


def test_an_agent_sees_where_it_has_arrived_before_it_jumps() -> None:
    mdp = Mdp((0, 1, 2), (({1: HALF, 2: HALF},), ({1: SURE},), ({2: SURE},)))
    formula = parse("F G a | F G b").formula
    assert storm_probability(mdp, formula) == 1
    assert best_probability(mdp, translate(formula, ABC)) == 1


def test_end_components_are_won_by_a_marked_choice_inside_and_not_by_one_that_leaves() -> None:
    stay, leave = Choice(False, {0: 1.0}), Choice(True, {0: 0.25, 1: 0.75})
    lost, won = Choice(False, {1: 1.0}), Choice(True, {1: 1.0})
    assert buchi_probability([[stay, leave], [lost]]) == 0
    assert buchi_probability([[stay, leave], [won]]) == 1
    assert buchi_probability([[replace(stay, marked=True), leave], [lost]]) == 1
    assert buchi_probability([[stay, leave], []]) == 0
    dice = Choice(False, {0: 0.5, 1: 0.25, 2: 0.25})
    assert buchi_probability([[dice], [Choice(True, {1: 1.0})], []]) == pytest.approx(0.5)


def early(formula: Formula, names: tuple[str, ...]) -> Ldba:
    """Accepts every word, but has to say before each letter what it will be."""
    edges = (
        Edge(0, 3, EVERY),
        Edge(1, 0, (Cube(1, 1),)),
        Edge(1, 3, (Cube(1, 0),)),
        Edge(2, 0, (Cube(1, 0),)),
        Edge(2, 3, (Cube(1, 1),)),
        Edge(3, 3, EVERY),
    )
    jumps = ((0, 1), (0, 2))
    text = to_text(formula)
    return Ldba(names, (text, text, text, "false"), frozenset({0}), 3, edges, jumps)


def guess(formula: Formula, names: tuple[str, ...]) -> Ldba:
    """Accepts every word, but guesses the second letter before it is there: a, or not."""
    edges = (
        Edge(0, 5, EVERY),
        Edge(1, 3, EVERY),
        Edge(2, 4, EVERY),
        Edge(3, 5, (Cube(1, 0),)),
        Edge(3, 6, (Cube(1, 1),)),
        Edge(4, 5, (Cube(1, 1),)),
        Edge(4, 6, (Cube(1, 0),)),
        Edge(5, 5, EVERY),
        Edge(6, 6, EVERY),
    )
    names_of = ("X a | X !a", "X a", "X !a", "a", "!a", "false", "true")
    jumps = ((0, 1), (0, 2))
    return Ldba(names, names_of, frozenset({6}), 5, edges, jumps)


def test_an_automaton_that_guesses_the_next_letter_is_found_out() -> None:
    formula = parse("true").formula
    ldba = guess(formula, ABC)
    generator = random.Random("guess")
    words = [random_lasso(generator, ABC) for _ in range(200)]
    assert all(accepts(ldba, word) for word in words), "as a language there is nothing wrong"
    pairs = [random_pair(3, number, False) for number in range(200)]
    values = [best_probability(pair.mdp, ldba) for pair in pairs]
    lost = [value for value in values if value < 1 - TOLERANCE]
    assert len(lost) > 20
    assert all(storm_probability(pair.mdp, formula) == 1 for pair in pairs)


def test_guesses_as_late_as_the_letter_itself_cost_nothing() -> None:
    formula = parse("true").formula
    ldba = early(formula, ABC)
    pairs = [random_pair(3, number, False) for number in range(50)]
    assert [best_probability(pair.mdp, ldba) for pair in pairs] == pytest.approx([1.0] * 50)


def without_jumps(formula: Formula, names: tuple[str, ...]) -> Ldba:
    return replace(translate(formula, names), jumps=())


def with_other_marks(formula: Formula, names: tuple[str, ...]) -> Ldba:
    ldba = translate(formula, names)
    return replace(ldba, accepting=frozenset(ldba.states) - ldba.accepting - {ldba.sink})


def with_other_letters(formula: Formula, names: tuple[str, ...]) -> Ldba:
    a, b, *others = names
    return replace(translate(formula, (b, a, *others)), propositions=names)


@pytest.mark.parametrize("wrong", [without_jumps, with_other_marks, with_other_letters])
def test_wrong_automata_are_found_out(wrong: Callable[..., Ldba]) -> None:
    series = compare(60, 4, True, {"wrong": wrong})
    assert len(series.wrong) > 5


def test_storm_understands_our_formulas_as_the_lasso_oracle_does() -> None:
    generator = random.Random("both oracles")
    for _ in range(300):
        formula, word = random_formula(generator, ABC, 8), random_lasso(generator, ABC)
        last = len(word.letters) - 1
        following = [*range(1, last + 1), len(word.stem)]
        mdp = Mdp(word.letters, tuple(({t: SURE},) for t in following))
        found = storm_probability(mdp, formula)
        assert found is None or found == holds(formula, word, ABC), (to_text(formula), word)
