"""Runs with their choices, and runs that accept an infinite word."""

from __future__ import annotations

import random

import pytest
from hypothesis import given

from tests.strategies import formulas, lassos, random_formula
from tiloilc.automaton import Ldba, translate
from tiloilc.automaton.language.trace import Trace, accepting_run, unrolled
from tiloilc.ltl import Lasso, holds, parse
from tiloilc.ltl.ast import Formula

ABC = ("a", "b", "c")


def automaton(text: str) -> Ldba:
    parsed = parse(text)
    return translate(parsed.formula, parsed.propositions)


@given(formulas(ABC, 8), lassos(ABC))
def test_a_word_has_an_accepting_run_just_if_it_satisfies_the_formula(
    formula: Formula, word: Lasso
) -> None:
    ldba = translate(formula, ABC)
    found = accepting_run(ldba, word)
    assert (found is not None) == holds(formula, word, ABC)
    if found is not None:
        states, begin = found
        around = states[begin:]
        assert set(around) & ldba.accepting
        letters = unrolled(word, len(states) + len(around))
        run = Trace(ldba).follow(letters, (*states, *around))
        assert run.state == states[-1]


def test_a_run_goes_on_and_back() -> None:
    start = Trace(automaton("F G y & G !b"))
    first = start.read(1)
    assert (first.state, first.options(1)) == (0, (0, 1))
    jumped = first.read(1, 1)
    assert (jumped.state, jumped.visits, jumped.lost) == (1, 1, False)
    assert jumped.back() == first
    assert start.back() == start
    assert jumped.read(3).lost
    with pytest.raises(AssertionError, match="none of"):
        jumped.read(1, 0)


def test_visits_are_those_of_the_states_after_each_letter() -> None:
    generator = random.Random("visits")
    for _ in range(50):
        ldba = translate(random_formula(generator, ABC, 8), ABC)
        letters = [generator.randrange(8) for _ in range(10)]
        run = Trace(ldba)
        for letter in letters:
            run = run.read(letter)
        states = [step.state for step in run.steps]
        assert run.visits == sum(state in ldba.accepting for state in states)
        if not ldba.jumps:
            assert states == ldba.run(letters)
