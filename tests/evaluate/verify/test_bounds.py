"""Clopper–Pearson bounds, against sums of binomial probabilities."""

from math import comb

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tiloilc.evaluate.verify.bounds import clopper_pearson, trials_needed


def at_most(successes: int, trials: int, p: float) -> float:
    return sum(comb(trials, i) * p**i * (1 - p) ** (trials - i) for i in range(successes + 1))


@settings(max_examples=60)
@given(st.integers(1, 60).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_each_end_is_where_the_outcome_becomes_as_rare_as_half_of_the_rest(
    given: tuple[int, int],
) -> None:
    successes, trials = given
    found = clopper_pearson(successes, trials, 0.9)
    assert 0 <= found.low <= successes / trials <= found.high <= 1
    if successes:
        assert 1 - at_most(successes - 1, trials, found.low) == pytest.approx(0.05)
    else:
        assert found.low == 0
    if successes < trials:
        assert at_most(successes, trials, found.high) == pytest.approx(0.05)
    else:
        assert found.high == 1


def test_all_of_a_hundred_are_fine_is_no_proof_of_more_than_96_percent() -> None:
    assert clopper_pearson(100, 100, 0.95).low == pytest.approx(0.025**0.01)
    assert clopper_pearson(0, 100, 0.95).high == pytest.approx(1 - 0.025**0.01)


@pytest.mark.parametrize("p", [0.02, 0.3, 0.5, 0.97])
def test_the_bounds_hold_the_probability_as_often_as_they_say(p: float) -> None:
    trials = 40
    covered = 0.0
    for successes in range(trials + 1):
        found = clopper_pearson(successes, trials, 0.95)
        if found.low <= p <= found.high:
            covered += comb(trials, successes) * p**successes * (1 - p) ** (trials - successes)
    assert covered >= 0.95


@pytest.mark.parametrize(("rate", "expected"), [(0.5, 402), (1.0, 36), (0.0, 36)])
def test_so_many_trials_are_needed_for_bounds_ten_percent_apart(rate: float, expected: int) -> None:
    assert trials_needed(rate, 0.05, 0.95) == expected
    found = clopper_pearson(int(rate * expected), expected, 0.95)
    before = clopper_pearson(int(rate * (expected - 1)), expected - 1, 0.95)
    assert found.high - found.low <= 0.1 < before.high - before.low


def test_what_a_half_needs_is_enough_whatever_comes() -> None:
    trials = trials_needed(0.5, 0.1, 0.95)
    assert trials is not None
    for successes in range(trials + 1):
        found = clopper_pearson(successes, trials, 0.95)
        assert found.high - found.low <= 0.2


def test_more_precision_and_more_confidence_need_more_trials() -> None:
    some = trials_needed(0.8, 0.1, 0.9)
    assert some is not None
    assert some < (trials_needed(0.8, 0.05, 0.9) or 0)
    assert some < (trials_needed(0.8, 0.1, 0.999) or 0)
    assert trials_needed(0.5, 1e-5, 0.95) is None
