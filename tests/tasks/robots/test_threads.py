"""Copies of a robot's task, by threads or not, are its single environment."""

import gymnasium as gym
import numpy as np
import pytest

import tiloilc.tasks
from tiloilc.product import Copies
from tiloilc.spec.model import Environment

ROBOTS = [id for id in tiloilc.tasks.IDS if gym.spec(id).vector_entry_point is None]


def test_there_are_seven_robots() -> None:
    assert len(ROBOTS) == 7


@pytest.mark.slow
@pytest.mark.parametrize("id", ROBOTS)
def test_copies_by_threads_are_single_environments_over_a_thousand_steps(
    id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tiloilc.product.environment._cores", lambda: 2)
    monkeypatch.setattr("tiloilc.product.environment.LONG_STEP", 0.0)
    many = Copies(Environment(id=id, horizon=1000), 2)
    many.action_space.seed(0)
    seen = [many.reset([5, 6], np.ones(2, np.bool_))]
    actions = [[many.action_space.sample() for _ in range(2)] for _ in range(1000)]
    seen += [many.step(np.array(pair))[0] for pair in actions]
    assert many._threads is not None
    many.close()
    for copy in range(2):
        env = gym.make(id)
        alone = [env.reset(seed=5 + copy)[0]]
        alone += [env.step(pair[copy])[0] for pair in actions]
        np.testing.assert_array_equal(np.stack(seen)[:, copy], np.array(alone), strict=True)
