from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from tests.product import worlds
from tiloilc.product import Copies
from tiloilc.spec.model import Environment


def copies(name: str, count: int, **kwargs: Any) -> Copies:
    return Copies(Environment(id=name, horizon=10, kwargs=kwargs), count)


def everyone(n: int) -> np.ndarray:
    return np.ones(n, dtype=np.bool_)


@pytest.mark.parametrize("name", ["tiloilc/FlatWorld-v0", "tiloilc/GridCircular-v0"])
def test_copies_step_like_single_environments(name: str) -> None:
    many = copies(name, 3)
    seen = [many.reset([5, 6, 7], everyone(3))]
    singles = [gym.make(name) for _ in range(3)]
    alone = [[env.reset(seed=5 + i)[0]] for i, env in enumerate(singles)]
    rng = np.random.default_rng(0)
    for _ in range(20):
        space = many.action_space
        actions = (
            rng.uniform(-1, 1, (3, *(space.shape or ()))).astype(np.float32)
            if isinstance(space, gym.spaces.Box)
            else rng.integers(space.n, size=3)
        )
        seen.append(many.step(actions)[0])
        for env, action, row in zip(singles, actions, alone, strict=True):
            row.append(env.step(action)[0])
    expected = np.array(alone, dtype=np.float32).swapaxes(0, 1)
    assert np.array_equal(np.stack(seen), expected)


@pytest.mark.parametrize("name", ["tiloilc/FlatWorld-v0", "TestsDrift-v0", "Pendulum-v1"])
def test_a_reset_of_some_leaves_the_others_where_they_are(name: str) -> None:
    many = copies(name, 3)
    first = many.reset([1, 2, 3], everyone(3))
    after, _ = many.step(np.zeros((3, *many.action_space.shape), np.float32))
    again = many.reset([1, 9, 9], np.array([True, False, False]))
    assert np.array_equal(again[0], first[0])
    assert np.array_equal(again[1:], after[1:])


def test_observations_are_copies_that_no_step_overwrites() -> None:
    for name in ("TestsDrift-v0", "tiloilc/FlatWorld-v0"):
        many = copies(name, 2)
        first = many.reset([1, 2], everyone(2))
        kept = first.copy()
        second, _ = many.step(np.ones((2, *many.action_space.shape), np.float32))
        assert np.array_equal(first, kept)
        assert not np.shares_memory(first, second)


def test_an_environments_own_time_limit_does_not_count() -> None:
    many = copies("TestsShort-v0", 2, size=100)
    many.reset([1, 2], everyone(2))
    for t in range(1, 11):
        seen, ended = many.step(np.array([2, 2]))
        assert seen[:, 0].tolist() == [t, t]
        assert not ended.any()


def test_who_has_terminated_is_told_apart() -> None:
    many = copies("TestsLine-v0", 2, size=2, ends=True)
    many.reset([1, 2], everyone(2))
    assert many.step(np.array([2, 1]))[1].tolist() == [True, False]


def test_a_dict_is_flattened_as_gymnasium_does() -> None:
    many = copies("TestsParts-v0", 2)
    assert many.dimensions == 5
    assert not many.finite
    assert many.reset([1, 2], everyone(2)).tolist() == [[0.5, -0.5, 0, 1, 0]] * 2
    assert many.step(np.array([0, 1]))[0].tolist() == [[0, 0, 0, 0, 1]] * 2


@pytest.mark.parametrize(
    ("name", "finite", "dimensions"),
    [
        ("tiloilc/GridCircular-v0", True, 2),
        ("tiloilc/FlatWorld-v0", False, 2),
        ("TestsLine-v0", True, 1),
        ("TestsSwitches-v0", True, 3),
        ("Pendulum-v1", False, 3),
        ("CartPole-v1", False, 4),
    ],
)
def test_spaces_are_finite_or_not(name: str, finite: bool, dimensions: int) -> None:
    many = copies(name, 1)
    assert (many.finite, many.dimensions) == (finite, dimensions)
    assert many.reset([0], everyone(1)).shape == (1, dimensions)
    many.close()


def test_a_batched_form_that_resets_by_itself_is_not_used() -> None:
    assert gym.spec("CartPole-v1").vector_entry_point is not None
    assert copies("CartPole-v1", 2).vector is None
    assert copies("tiloilc/FlatWorld-v0", 2).vector is not None


@pytest.mark.parametrize("name", ["tiloilc/FlatWorld-v0", "tiloilc/GridCircular-v0"])
def test_environments_use_no_global_randomness(name: str) -> None:
    runs = []
    for seed in (0, 1):
        np.random.seed(seed)  # noqa: NPY002  # the point of the test
        many = copies(name, 2)
        shape = (2, *many.action_space.shape)
        seen = [many.reset([1, 2], everyone(2))]
        kind = np.float32 if shape[1:] else np.int64
        seen += [many.step(np.ones(shape, kind))[0] for _ in range(5)]
        runs.append(np.stack(seen))
    assert np.array_equal(*runs)


def test_worlds_of_the_tests_are_registered() -> None:
    assert worlds.Line().observation_space.shape == (1,)


def test_threads_step_mujocos_copies_as_one_after_the_other_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def rollout() -> tuple[bool, np.ndarray]:
        many = copies("HalfCheetah-v5", 5)
        seen = [many.reset([3, 1, 4, 1, 5], everyone(5))]
        many.action_space.seed(0)
        for _ in range(30):
            actions = np.array([many.action_space.sample() for _ in range(5)])
            seen.append(many.step(actions)[0])
        threads = many._threads is not None
        many.close()
        return threads, np.stack(seen)

    monkeypatch.setattr("tiloilc.product.environment._cores", lambda: 2)
    monkeypatch.setattr("tiloilc.product.environment.LONG_STEP", 0.0)
    by_threads, first = rollout()
    monkeypatch.setattr("tiloilc.product.environment.LONG_STEP", 100.0)
    by_none, second = rollout()
    assert (by_threads, by_none) == (True, False)
    assert np.array_equal(first, second)
