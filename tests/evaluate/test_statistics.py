"""Statistics against hand numbers, and the intervals against what they promise."""

import numpy as np
import pytest

from tiloilc.evaluate.statistics import (
    area_under_curve,
    band,
    difference,
    generator,
    interquartile_mean,
    mean,
    probability_of_improvement,
    steps_to_threshold,
    stratified_bootstrap,
    summarise,
)


def test_interquartile_mean_leaves_out_the_outer_quarters() -> None:
    assert interquartile_mean(np.array([0.0, 1.0, 2.0, 99.0])) == pytest.approx(1.5)
    ten = np.array([-50.0, -40, 1, 2, 3, 4, 5, 6, 70, 80])
    assert interquartile_mean(ten) == pytest.approx(3.5)


def test_a_summary_has_mean_sample_deviation_and_intervals_around_them() -> None:
    summary = summarise([2.0, 3.0, 3.0, 4.0], generator())
    assert summary is not None
    assert (summary.count, summary.mean, summary.iqm) == (4, 3.0, 3.0)
    assert summary.sd == pytest.approx(np.sqrt(2 / 3))
    assert 2.0 <= summary.mean_interval.low < 3.0 < summary.mean_interval.high <= 4.0


def test_undefined_seeds_are_left_out_and_counted_out() -> None:
    summary = summarise([None, 5.0, float("nan"), 7.0], generator())
    assert summary is not None
    assert (summary.count, summary.mean) == (2, 6.0)
    assert summarise([None, None], generator()) is None


def test_one_seed_has_no_spread() -> None:
    summary = summarise([3.0], generator())
    assert summary is not None
    assert (summary.sd, summary.mean_interval.low, summary.mean_interval.high) == (0.0, 3.0, 3.0)


def test_the_same_generator_gives_the_same_interval() -> None:
    values = list(np.random.default_rng(0).normal(size=10))
    assert summarise(values, generator(7)) == summarise(values, generator(7))
    assert summarise(values, generator(7)) != summarise(values, generator(8))


def test_strata_keep_their_share_in_every_resample() -> None:
    # two tasks without spread of their own: unstratified resampling would widen the interval
    interval = stratified_bootstrap([np.zeros(5), np.full(5, 10.0)], mean, generator())
    assert (interval.low, interval.high) == (5.0, 5.0)


def test_intervals_cover_the_true_mean_about_as_often_as_they_say() -> None:
    rng = generator(11)
    hits = 0
    for _ in range(200):
        sample = rng.normal(3.0, 1.0, size=30)
        interval = stratified_bootstrap([sample], mean, rng, resamples=400)
        hits += interval.low <= 3.0 <= interval.high
    assert 176 <= hits <= 198  # 95 % nominal; percentile intervals of 30 are a little narrow


def test_a_band_follows_the_mean_and_leaves_gaps_where_nothing_is_known() -> None:
    curves = np.array([[0.0, 2.0, 4.0], [np.nan, 3.0, 5.0], [np.nan] * 3])
    result = band(curves, generator())
    assert result.mean.tolist() == pytest.approx([2.0, 4.0, np.nan], nan_ok=True)
    assert result.low[0] < 2.0 < result.high[0]
    assert 3.0 <= result.low[1] <= 4.0 <= result.high[1] <= 5.0
    assert np.isnan(result.low[2])


def test_the_threshold_is_crossed_by_the_mean_over_seeds_at_an_evaluation() -> None:
    curves = np.array([[0.0, 0.0], [5.0, 0.0], [4.0, 4.0]])
    assert steps_to_threshold([0, 100, 200], curves, 3.6) == 200
    assert steps_to_threshold([0, 100, 200], curves, 2.5) == 100
    assert steps_to_threshold([0, 100, 200], curves, 4.5) is None


def test_area_is_the_mean_height_over_uneven_steps() -> None:
    curves = np.array([[0.0, 1.0], [2.0, 1.0], [2.0, 1.0]])
    # trapezoids: (0+2)/2 · 100 + 2 · 300 = 700, over 400 steps
    assert area_under_curve([0, 100, 400], curves).tolist() == pytest.approx([1.75, 1.0])
    assert area_under_curve([50], curves[:1]).tolist() == [0.0, 1.0]


def test_the_probability_of_improvement_counts_pairs_and_half_of_ties() -> None:
    x, y = np.array([1.0, 2.0, 3.0]), np.array([2.0, 0.0])
    found, _ = probability_of_improvement([(x, y)], generator())
    assert found == pytest.approx((1 + 1.5 + 2) / 6)  # of each x in turn
    turned, _ = probability_of_improvement([(y, x)], generator())
    assert found + turned == pytest.approx(1.0)


def test_each_task_weighs_the_same_in_the_probability_of_improvement() -> None:
    won = (np.ones(2), np.zeros(50))
    lost = (np.zeros(40), np.ones(3))
    found, interval = probability_of_improvement([won, lost], generator())
    assert (found, interval.low, interval.high) == (0.5, 0.5, 0.5)


def test_the_interval_of_improvement_holds_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(5)
    inside = 0
    for _ in range(200):
        pair = rng.normal(0.5, 1, 20), rng.normal(0, 1, 20)
        _, interval = probability_of_improvement([pair], rng, resamples=300)
        inside += interval.low <= 0.638 <= interval.high  # P(N(0.5, 2) > 0)
    assert 0.88 <= inside / 200 <= 0.99


def test_a_difference_is_of_means_and_has_its_interval() -> None:
    value, interval = difference(np.array([1.0, 3.0]), np.array([5.0, 5.0, 5.0]), generator())
    assert (value, interval.low, interval.high) == (3.0, 2.0, 4.0)
