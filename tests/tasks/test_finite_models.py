import gymnasium as gym
import numpy as np
import pytest

from tiloilc.tasks import finite_model
from tiloilc.tasks.flatworld import BLUE, GREEN, RED, YELLOW


@pytest.mark.parametrize(
    ("name", "kwargs"),
    [
        ("GridAvoid", {"distance": 11}),
        ("GridSequential", {"zones": 4}),
        ("GridCircular", {"zones": 4}),
        ("GridCircular", {"corners": False}),
    ],
)
def test_the_model_of_a_grid_steps_as_the_environment_does(
    name: str, kwargs: dict[str, object]
) -> None:
    vector = gym.make_vec(f"tiloilc/{name}-v0", num_envs=1, **kwargs)
    model = finite_model(vector)
    assert model is not None
    assert model.exact
    start, _ = vector.reset()
    np.testing.assert_array_equal(model.observations[model.initial], start)
    count = len(model.observations)
    copies = gym.make_vec(f"tiloilc/{name}-v0", num_envs=count, **kwargs)
    copies.reset()
    for action in range(model.successor.shape[1]):
        copies.set_state(model.observations)
        seen, *_ = copies.step(np.full(count, model.actions[action]))
        np.testing.assert_array_equal(model.observations[model.successor[:, action]], seen)


@pytest.mark.parametrize("kwargs", [{}, {"dt": 0.25}, {"random_start": True}])
def test_every_move_of_flatworlds_lattice_is_a_real_one(kwargs: dict[str, object]) -> None:
    vector = gym.make_vec("tiloilc/FlatWorld-v0", num_envs=1, **kwargs)
    model = finite_model(vector)
    assert model is not None
    assert not model.exact
    stay = int(np.flatnonzero((model.actions == 0).all(axis=1))[0])
    own = np.arange(len(model.observations))
    np.testing.assert_array_equal(model.successor[:, stay], own)
    for action in (0, 17, 40, 63, 80):
        moves = model.successor[:, action] != own
        if action == stay:
            continue
        copies = gym.make_vec("tiloilc/FlatWorld-v0", num_envs=int(moves.sum()), **kwargs)
        copies.reset()
        copies.set_state(model.observations[moves])
        seen, *_ = copies.step(np.tile(model.actions[action], (int(moves.sum()), 1)))
        target = model.observations[model.successor[moves, action]]
        np.testing.assert_allclose(seen, target, atol=1e-5)


def test_no_lattice_point_is_so_near_a_rim_that_rounding_could_label_it() -> None:
    model = finite_model(gym.make("tiloilc/FlatWorld-v0"))
    assert model is not None
    for disc in (RED, GREEN, YELLOW, BLUE):
        gap = np.linalg.norm(model.observations - np.array(disc.center), axis=1) - disc.radius
        assert np.abs(gap).min() > 5e-4


def test_the_lattice_begins_where_flatworld_does() -> None:
    model = finite_model(gym.make("tiloilc/FlatWorld-v0"))
    assert model is not None
    np.testing.assert_allclose(model.observations[model.initial], [[-1, -1]])
    assert len(model.observations) > 1600


def test_the_model_of_the_rooms_steps_as_the_environment_does() -> None:
    vector = gym.make_vec("tiloilc/SixteenRooms-v0", num_envs=1, noise=0.0)
    model = finite_model(vector)
    assert model is not None
    assert not model.exact
    start, _ = vector.reset()
    np.testing.assert_array_equal(model.observations[model.initial], start)
    count = len(model.observations)
    assert count == 2 * (16 * 81 + 24 * 3), "9 by 9 in a room, 3 in a door"
    copies = gym.make_vec("tiloilc/SixteenRooms-v0", num_envs=count)
    copies.reset()
    for number, action in enumerate(model.actions):
        copies.set_state(model.observations)
        seen, *_ = copies.step(np.tile(action, (count, 1)))
        np.testing.assert_array_equal(model.observations[model.successor[:, number]], seen)


def test_an_environment_without_a_model_has_none() -> None:
    assert finite_model(gym.make("CartPole-v1")) is None
    assert finite_model(gym.make("tiloilc/Carlo-v0")) is None


def test_what_is_no_model_is_refused() -> None:
    class Wrong:
        def finite_model(self) -> str:
            return "a model"

    with pytest.raises(TypeError, match="finite model"):
        finite_model(Wrong())
