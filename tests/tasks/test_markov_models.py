"""Decision processes that environments publish: by a method, by a grid, by Gymnasium's tables."""

import gymnasium as gym
import numpy as np
import pytest

from tests.evaluate.verify.worlds import Gamble, gamble
from tiloilc.tasks import MarkovModel, finite_model, markov_model


def found_in(env: object) -> MarkovModel:
    model = markov_model(env)
    assert model is not None
    return model


def test_a_grid_leaves_nothing_to_chance() -> None:
    env = gym.make("tiloilc/GridCircular-v0", zones=3)
    model, finite = found_in(env), finite_model(env)
    assert finite is not None
    assert model.exact
    np.testing.assert_array_equal(model.successor[..., 0], finite.successor)
    assert (model.probability == 1).all()
    assert np.flatnonzero(model.initial).tolist() == finite.initial.tolist()
    assert model.initial.sum() == 1


def test_a_lattice_is_not_the_world_itself() -> None:
    assert not found_in(gym.make("tiloilc/FlatWorld-v0")).exact


def test_what_an_environment_publishes_is_taken() -> None:
    model = found_in(gym.make("TestsGamble-v0"))
    np.testing.assert_array_equal(model.probability, gamble().probability)
    assert markov_model(gym.make("TestsGamble-v0", silent=True)) is None
    assert markov_model(gym.make("CartPole-v1")) is None


def test_what_is_published_must_be_a_model() -> None:
    class Odd(Gamble):
        def markov_model(self) -> object:  # type: ignore[override]
            return "no model"

    with pytest.raises(TypeError, match="publishes str as its Markov model"):
        markov_model(Odd())


@pytest.mark.parametrize("name", ["FrozenLake-v1", "CliffWalking-v1"])
def test_gymnasiums_tables_are_read_and_ends_are_never_left(name: str) -> None:
    env = gym.make(name)
    model = found_in(env)
    n = env.observation_space.n
    np.testing.assert_allclose(model.probability.sum(axis=2), 1)
    assert model.initial.sum() == pytest.approx(1)
    twins = np.arange(n, len(model.initial))
    assert len(twins)
    assert (model.successor[twins] == twins[:, None, None]).all()
    assert (model.initial[twins] == 0).all()
    assert (model.observations[twins, 0] < n).all()
    rng = np.random.default_rng(1)
    for seed in range(20):
        s, _ = env.reset(seed=seed)
        assert model.initial[s] > 0
        for _ in range(50):
            action = int(rng.integers(env.action_space.n))
            likely = model.probability[s, action] > 0
            after = model.successor[s, action][likely].tolist()
            shown, _, over, _, _ = env.step(action)
            reached = [t for t in after if model.observations[t, 0] == shown and (t >= n) == over]
            assert reached
            if over:
                break
            s = shown
