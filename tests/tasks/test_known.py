"""What environments without a finite model publish about the best that is known."""

import gymnasium as gym
import numpy as np
import pytest

from tests.demos.examples import ROAD
from tiloilc.tasks import known_best
from tiloilc.tasks.carlo.road import farthest


@pytest.mark.parametrize("kwargs", [{}, {"heading": "angle"}, {"start": 1}])
def test_the_best_drives_begin_where_episodes_do_and_never_crash(
    kwargs: dict[str, object],
) -> None:
    env = gym.make("tiloilc/Carlo-v0", **kwargs)
    start, _ = env.reset(seed=0)
    found = known_best(env, 120)
    assert found
    for known in found:
        assert known.observations.shape == (1, 121, len(start))
        np.testing.assert_array_equal(known.observations[0, 0], start)
        assert not (ROAD(known.observations[0]) & 4).any()


def test_no_step_of_the_best_drives_is_longer_than_a_car_can_go() -> None:
    for known in known_best(gym.make("tiloilc/Carlo-v0"), 500):
        places = 60 * known.observations[0, :, :2].astype(float)
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        assert steps[0] == pytest.approx(0.15, abs=1e-4)
        assert (np.diff(steps) < 0.0095).all() or steps[1] == pytest.approx(0.3, abs=0.01)
        assert steps.max() <= 3 + 1e-4


def test_nobody_gets_farther_round_than_the_bound() -> None:
    bound, _ = farthest(500, 0.1)
    for known in known_best(gym.make("tiloilc/Carlo-v0"), 500):
        x, y = (60 * known.observations[0, :, :2].astype(float) - 30).T
        turned = np.unwrap(np.arctan2(y, x))
        assert 0.9 * bound < abs(turned[-1] - turned[0]) < bound


def test_the_bound_is_the_one_computed_by_hand() -> None:
    # a step of 0.15 m at 16 m from the middle, then steps of 0.3 m and more
    assert farthest(1, 0.1)[0] == pytest.approx(0.15 / 16, rel=1e-4)
    assert farthest(2, 0.1)[0] == pytest.approx((0.15 + 0.3047) / 16, rel=1e-4)
    # to the first region 0.548 rad, to the other 2.666 more: 51.4 m at least, in 7.7 s at best
    assert [farthest(horizon, 0.1)[1] for horizon in (75, 80)] == [0, 1]
    assert farthest(500, 0.1)[1] == 13


def test_where_starts_are_random_nothing_is_claimed() -> None:
    assert known_best(gym.make("tiloilc/Carlo-v0", random_start=True), 500) == ()


def test_an_environment_that_knows_nothing_publishes_nothing() -> None:
    assert known_best(gym.make("CartPole-v1"), 10) == ()
    assert known_best(gym.make("tiloilc/FlatWorld-v0"), 10) == ()


def test_what_is_nothing_known_is_refused() -> None:
    class Wrong:
        def known_best(self, horizon: int) -> list[str]:
            return ["all of it"]

    with pytest.raises(TypeError, match="as a known best"):
        known_best(Wrong(), 10)
