import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, VectorEnv

import tiloilc.tasks
from tiloilc.tasks.batched import BatchedEnv

VARIANTS = [
    ("FlatWorld", {}),
    ("FlatWorld", {"random_start": True}),
    ("FlatWorld", {"dt": 0.1}),
    ("GridAvoid", {"distance": 9}),
    ("GridSequential", {"zones": 5}),
    ("GridCircular", {"zones": 4}),
    ("GridCircular", {"zones": 3, "core": 1, "corners": False}),
    ("Carlo", {}),
    ("Carlo", {"heading": "angle", "start": 2}),
    ("Carlo", {"random_start": True, "dt": 0.2}),
    ("SixteenRooms", {}),
    ("SixteenRooms", {"noise": 2.0}),
]
every_variant = pytest.mark.parametrize(("name", "kwargs"), VARIANTS)


def batch(name: str, kwargs: dict[str, object], n: int, **more: object) -> VectorEnv:
    return gym.make_vec(f"tiloilc/{name}-v0", num_envs=n, **kwargs, **more)


def actions_of(vector: VectorEnv, steps: int, seed: int = 0) -> np.ndarray:
    vector.action_space.seed(seed)
    return np.array([vector.action_space.sample() for _ in range(steps)])


def rollout(vector: VectorEnv, actions: np.ndarray, seed: int | list[int]) -> np.ndarray:
    seen = [vector.reset(seed=seed)[0]]
    seen += [vector.step(a)[0] for a in actions]
    return np.array(seen)


def test_every_id_is_registered_and_what_is_no_robot_in_both_forms() -> None:
    for env_id in tiloilc.tasks.IDS:
        spec = gym.spec(env_id)
        assert spec.entry_point
        assert bool(spec.vector_entry_point) == (".robots." not in spec.entry_point)
        assert spec.max_episode_steps is None


@every_variant
def test_the_single_form_passes_gymnasiums_checker(name: str, kwargs: dict[str, object]) -> None:
    check_env(gym.make(f"tiloilc/{name}-v0", render_mode="rgb_array", **kwargs).unwrapped)


@every_variant
def test_observations_belong_to_the_space_that_is_declared(
    name: str, kwargs: dict[str, object]
) -> None:
    vector = batch(name, kwargs, 5)
    seen = rollout(vector, actions_of(vector, 60), seed=1)
    space = vector.single_observation_space
    assert seen.dtype == space.dtype
    assert all(space.contains(row) for row in seen.reshape(-1, *space.shape))


@every_variant
def test_equal_seeds_and_actions_give_equal_bits(name: str, kwargs: dict[str, object]) -> None:
    first, second = batch(name, kwargs, 4), batch(name, kwargs, 4)
    actions = actions_of(first, 50)
    rollout(second, actions[:7], seed=99)
    np.testing.assert_array_equal(
        rollout(first, actions, seed=3), rollout(second, actions, seed=3), strict=True
    )


@every_variant
def test_a_copy_of_the_batch_is_the_single_environment(
    name: str, kwargs: dict[str, object]
) -> None:
    vector = batch(name, kwargs, 3)
    actions = actions_of(vector, 1000)
    together = rollout(vector, actions, seed=5)
    for i in range(3):
        env = gym.make(f"tiloilc/{name}-v0", **kwargs)
        alone = [env.reset(seed=5 + i)[0]]
        alone += [env.step(a[i])[0] for a in actions]
        np.testing.assert_array_equal(together[:, i], np.array(alone), strict=True)


@every_variant
def test_reset_again_without_a_seed_goes_on_with_the_same_random_numbers(
    name: str, kwargs: dict[str, object]
) -> None:
    vector = batch(name, kwargs, 2)
    env = gym.make(f"tiloilc/{name}-v0", **kwargs)
    vector.reset(seed=[11, 12])
    env.reset(seed=11)
    for _ in range(3):
        np.testing.assert_array_equal(vector.reset()[0][0], env.reset()[0], strict=True)


def test_a_masked_reset_touches_only_the_named_copies() -> None:
    vector = batch("FlatWorld", {"random_start": True}, 3)
    vector.reset(seed=0)
    before, *_ = vector.step(np.ones((3, 2), np.float32))
    mask = np.array([False, True, False])
    after, _ = vector.reset(seed=[7, 8, 9], options={"reset_mask": mask})
    np.testing.assert_array_equal(after[~mask], before[~mask])
    alone, _ = gym.make("tiloilc/FlatWorld-v0", random_start=True).reset(seed=8)
    np.testing.assert_array_equal(after[1], alone)
    again, _ = vector.reset(options={"reset_mask": np.array([True, False, False])})
    ours = gym.make("tiloilc/FlatWorld-v0", random_start=True)
    ours.reset(seed=0)
    np.testing.assert_array_equal(again[0], ours.reset()[0])


def test_the_options_of_a_reset_are_left_as_they_were() -> None:
    vector = batch("GridAvoid", {}, 2)
    options = {"reset_mask": np.array([True, True])}
    vector.reset(options=options)
    assert list(options) == ["reset_mask"]


def test_observations_handed_out_never_change_later() -> None:
    for name, kwargs in VARIANTS:
        vector = batch(name, kwargs, 2)
        first, _ = vector.reset(seed=0)
        kept = first.copy()
        second, *_ = vector.step(actions_of(vector, 1)[0])
        second[:] = 0
        vector.reset(seed=1)
        np.testing.assert_array_equal(first, kept)


def test_batches_never_end_or_restart_episodes_by_themselves() -> None:
    vector = batch("GridCircular", {}, 3)
    assert vector.metadata["autoreset_mode"] is AutoresetMode.DISABLED
    vector.reset(seed=0)
    for action in actions_of(vector, 300):
        _, rewards, terminated, truncated, info = vector.step(action)
        assert not terminated.any()
        assert not truncated.any()
        assert not rewards.any()
        assert info == {}


@pytest.mark.parametrize(
    ("seed", "options"),
    [
        ([1, 2], None),
        (None, {"reset_mask": np.array([True])}),
        (None, {"reset_mask": np.zeros(3, bool)}),
    ],
)
def test_seeds_and_masks_of_the_wrong_number_are_refused(seed: object, options: object) -> None:
    vector = batch("FlatWorld", {}, 3)
    vector.reset(seed=0)
    with pytest.raises(ValueError, match=r"seeds|reset_mask"):
        vector.reset(seed=seed, options=options)


def test_a_mask_that_is_not_boolean_is_refused() -> None:
    vector = batch("FlatWorld", {}, 2)
    with pytest.raises(TypeError, match="booleans"):
        vector.reset(options={"reset_mask": np.array([0, 1])})


def test_stepping_before_the_first_reset_is_refused() -> None:
    vector = batch("FlatWorld", {}, 2)
    with pytest.raises(gym.error.ResetNeeded):
        vector.step(np.zeros((2, 2)))


@pytest.mark.parametrize(
    ("name", "kwargs"),
    [
        ("FlatWorld", {"dt": 0}),
        ("GridAvoid", {"distance": 0}),
        ("GridSequential", {"zones": 6}),
        ("GridCircular", {"zones": 1}),
        ("GridCircular", {"core": 2}),
        ("Carlo", {"heading": "radians"}),
        ("Carlo", {"dt": 0}),
        ("Carlo", {"start": 4}),
        ("SixteenRooms", {"noise": -1}),
    ],
)
def test_parameters_out_of_range_are_refused(name: str, kwargs: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=next(iter(kwargs))):
        gym.make(f"tiloilc/{name}-v0", **kwargs)


def test_wrong_actions_are_refused() -> None:
    grid, flat = batch("GridAvoid", {}, 2), batch("FlatWorld", {}, 2)
    grid.reset()
    flat.reset()
    for wrong in (np.array([0, 5]), np.array([-1, 0]), np.array([0.0, 1.0]), np.array([0])):
        with pytest.raises(ValueError, match="actions must"):
            grid.step(wrong)
    with pytest.raises(ValueError, match="actions must"):
        flat.step(np.zeros((2, 3)))
    for name in ("Carlo", "SixteenRooms"):
        plane = batch(name, {}, 2)
        plane.reset()
        with pytest.raises(ValueError, match="actions must"):
            plane.step(np.zeros(2))


@every_variant
def test_a_state_can_be_restored_from_what_it_shows(name: str, kwargs: dict[str, object]) -> None:
    vector = batch(name, kwargs, 3)
    assert isinstance(vector, BatchedEnv)
    actions = actions_of(vector, 20)
    seen = rollout(vector, actions, seed=0)
    vector.set_state(seen[10])
    again = np.array([vector.step(a)[0] for a in actions[10:]])
    np.testing.assert_array_equal(again, seen[11:])


def test_fields_name_the_components_of_observations() -> None:
    for env_id in tiloilc.tasks.IDS:
        if not gym.spec(env_id).vector_entry_point:
            continue
        single, vector = gym.make(env_id).unwrapped, gym.make_vec(env_id, num_envs=2)
        assert single.observation_fields == vector.observation_fields
        covered = [np.r_[place] for place in single.observation_fields.values()]
        (size,) = single.observation_space.shape
        assert sorted(np.concatenate(covered).tolist()) == list(range(size))


def test_a_picture_shows_the_agent_where_it_is() -> None:
    vector = batch("FlatWorld", {}, 2, render_mode="rgb_array")
    vector.reset(seed=0)
    vector.step(np.array([[0, 0], [1, 1]]))
    here, there = vector.render()
    assert here.shape == there.shape == (256, 256, 3)
    assert here.dtype == np.uint8
    changed = np.argwhere((here != there).any(axis=-1))
    row, column = changed.min(axis=0), changed.max(axis=0)
    assert row[1] >= 50
    assert column[0] <= 206, "y grows upwards: (-1, -1) lies in the lower left"


def test_without_a_render_mode_there_is_no_picture() -> None:
    env = gym.make("tiloilc/GridAvoid-v0").unwrapped
    env.reset()
    assert env.render() is None
