"""What a verification shows of a probability that is asked for."""

from fractions import Fraction

import pytest

from tests.learn.examples import plan
from tests.plan.automata import stabilization
from tiloilc.evaluate.statistics import Interval
from tiloilc.evaluate.verify import Verification
from tiloilc.evaluate.verify.exact import Exact, Maximum
from tiloilc.evaluate.verify.results import Judged, Sampled


def found(probability: Fraction) -> Verification:
    """One agent, seed 3, and a task in which nobody can do better."""
    judged = Judged(3, Exact(probability, probability, False, 1))
    best = Maximum(probability, True, "by hand")
    made = plan(stabilization(), "TestsLine-v0")
    return Verification(made, "best", (judged,), None, best, ())


@pytest.mark.parametrize("text", ["0.1", "0.3", "0.7", "0.9", "1.0", "0.0"])
def test_nine_tenths_reach_what_is_asked_for_as_0_9(text: str) -> None:
    just = found(Fraction(text))
    assert just.possible(float(text))
    assert just.missing(float(text)) == ()


def test_what_is_short_of_certain_by_less_than_floats_can_tell_is_short_of_it() -> None:
    nearly = found(1 - Fraction(1, 10**20))
    assert float(nearly.judged[0].found.probability) == 1  # type: ignore[union-attr]
    assert not nearly.possible(1.0)
    assert nearly.missing(1.0) == (3,)


@pytest.mark.parametrize(("accepted", "agrees"), [(0.9, True), (0.96, False), (0.8, False)])
def test_walks_are_held_against_the_agents_own_run_of_the_automaton(
    accepted: float, agrees: bool
) -> None:
    known = Exact(Fraction(1), Fraction(str(accepted)), False, 4)
    walked = Sampled(9, 1, 10, Interval(0.85, 0.95), Interval(0.0, 0.2))
    assert Judged(3, known, walked).agrees is agrees
    assert Judged(3, known).agrees
