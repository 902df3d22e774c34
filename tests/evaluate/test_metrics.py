"""The metrics against numbers worked out by hand."""

import numpy as np
import pytest

from tiloilc.evaluate.metrics import METRICS, eventual_return, first_visit, measure


def bools(*rows: str) -> np.ndarray:
    return np.array([[character == "1" for character in row] for row in rows])


def test_eventual_return_weighs_each_visit_by_the_visits_before_it() -> None:
    # Gamma = 1, 1, .5, .5, .25: visits at i = 1, 3, 4 are worth 1 + .5 + .25
    assert eventual_return(bools("01011"), 0.5)[0] == pytest.approx(1.75)


def test_eventual_return_does_not_discount_waiting() -> None:
    assert eventual_return(bools("0001"), 0.9)[0] == pytest.approx(1.0)
    assert eventual_return(bools("1000"), 0.9)[0] == pytest.approx(1.0)


def test_eventual_return_of_fifty_accepting_states_is_the_cap_of_the_geometric_sum() -> None:
    assert eventual_return(bools("1" * 50), 0.99)[0] == pytest.approx(39.4993932)
    assert eventual_return(bools("1" * 500), 0.99)[0] == pytest.approx(99.3429517)


def test_eventual_return_equals_the_product_formula_written_out() -> None:
    states = np.random.default_rng(3).random((6, 40)) < 0.3
    for row, value in zip(states, eventual_return(states, 0.97), strict=True):
        expected = 0.0
        for i in range(len(row)):
            weight = 1.0
            for t in range(i):
                weight *= 0.97 if row[t] else 1.0
            expected += weight * row[i]
        assert value == pytest.approx(expected)


def test_first_visit_counts_steps_from_one_and_is_nan_without_a_visit() -> None:
    assert first_visit(bools("001", "100", "000")).tolist() == pytest.approx(
        [3, 1, np.nan], nan_ok=True
    )


def test_measures_of_two_seeds_are_means_over_their_episodes() -> None:
    accepting = np.stack([bools("0101", "0000"), bools("0000", "0000")])
    sink = np.stack([bools("0000", "0011"), bools("1111", "0001")])
    measured = measure(accepting, sink, gamma=0.5)
    assert measured.accepting_visits.tolist() == [1.0, 0.0]
    assert measured.eventual_return.tolist() == [0.75, 0.0]  # (1 + .5) / 2
    assert measured.violation_rate.tolist() == [0.5, 1.0]
    assert measured.success.tolist() == [0.5, 0.0]
    assert measured.to_json()["first_visit"] == [2.0, None]


def test_the_first_state_enters_the_return_but_is_no_visit() -> None:
    accepting, sink = bools("01"), bools("00")
    measured = measure(accepting, sink, gamma=0.5, start_accepting=np.array([True]))
    assert measured.eventual_return == 1.5
    assert measured.accepting_visits == 1.0
    assert measured.first_visit == 2.0


def test_json_has_every_metric_and_one_number_even_without_a_seed_axis() -> None:
    lists = measure(bools("01"), bools("00"), gamma=0.99).to_json()
    assert tuple(lists) == METRICS
    assert lists["accepting_visits"] == [1.0]


def test_an_accepting_sink_is_refused() -> None:
    with pytest.raises(AssertionError, match="never accepts"):
        measure(bools("1"), bools("1"), gamma=0.99)
