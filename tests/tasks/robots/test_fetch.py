"""The four Fetch tasks: what they are, apart from what is to be done in them."""

import dataclasses
import subprocess
import sys
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.tasks.robots.arms import DIMENSIONS, NAMES, make, moves, rollout
from tiloilc.tasks import Circle, experts_of

every_task = pytest.mark.parametrize("name", NAMES)


@every_task
def test_it_passes_gymnasiums_checker(name: str) -> None:
    env = make(name, render_mode="rgb_array")
    check_env(env)
    assert env.metadata["render_fps"] == round(1 / env.step_seconds) == 25
    env.close()


@every_task
def test_fields_cover_the_observation(name: str) -> None:
    env = make(name)
    covered = np.concatenate([np.r_[place] for place in env.observation_fields.values()])
    assert covered.tolist() == list(range(DIMENSIONS[name]))
    assert env.observation_space.shape == (DIMENSIONS[name],)
    assert env.observation_space.is_bounded()


@every_task
def test_equal_seeds_and_actions_give_equal_bits(name: str) -> None:
    first, second = make(name), make(name)
    actions = moves(25)
    rollout(second, moves(10, seed=4), seed=99)
    seen = rollout(first, actions, seed=3)
    np.testing.assert_array_equal(seen, rollout(second, actions, seed=3), strict=True)
    assert all(first.observation_space.contains(row) for row in seen)
    assert seen.dtype == np.float32


def test_environments_side_by_side_do_not_touch_each_other() -> None:
    actions = moves(20)
    alone = [rollout(make("FetchPlaceTray"), actions, seed=s) for s in (0, 1)]
    envs = [make("FetchPlaceTray") for _ in range(2)]
    together = [[env.reset(seed=s)[0]] for s, env in enumerate(envs)]
    for action in actions:
        for rows, env in zip(together, envs, strict=True):
            rows.append(env.step(action)[0])
    assert envs[0].model is envs[1].model, "the scene is built once"
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one, np.array(other))


@every_task
def test_nothing_is_paid_and_nothing_ends(name: str) -> None:
    env = make(name)
    env.reset(seed=0)
    for action in moves(10):
        _, reward, terminated, truncated, info = env.step(action)
        assert (reward, terminated, truncated, info) == (0.0, False, False, {})


def test_the_arm_moves_as_gymnasium_robotics_moves_it() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from gymnasium_robotics.envs.fetch.pick_and_place import MujocoFetchPickAndPlaceEnv

        theirs = MujocoFetchPickAndPlaceEnv()
        theirs.reset(seed=0)
    ours = make("FetchPlaceButton")
    first, _ = ours.reset(seed=0)
    theirs.data.qpos[:], theirs.data.qvel[:] = ours.data.qpos, ours.data.qvel
    theirs._mujoco.mj_forward(theirs.model, theirs.data)
    for action in moves(40).astype(np.float32):
        told = theirs.step(action)[0]["observation"].astype(np.float32)
        seen = ours.step(action)[0]
        bounds = ours.observation_space
        told = np.clip(told, bounds.low[:25], bounds.high[:25])
        np.testing.assert_allclose(seen[:25], told, rtol=0, atol=1e-5)
    assert np.abs(seen - first).max() > 0.05


def test_the_gripper_begins_where_it_should() -> None:
    avoid, _ = make("FetchAvoid").reset(seed=0)
    np.testing.assert_allclose(avoid[:3], [1.342, 0.749, 0.535], atol=1e-3)
    align, _ = make("FetchAlign").reset(seed=0)
    assert align[0] < align[9] - 0.04, "behind the first cube"
    assert abs(align[1] - align[10]) < 0.02
    assert align[2] < 0.45, "low enough to push"


def test_a_blocked_gripper_stays_closed_and_another_opens() -> None:
    for name, opens in (("FetchAvoid", False), ("FetchAlign", False), ("FetchPlaceTray", True)):
        env = make(name)
        env.reset(seed=0)
        for _ in range(4):
            seen = env.step(np.array([0.0, 0.0, 0.0, 1.0]))[0]
        assert bool(seen[env.observation_fields["fingers"]].min() > 0.04) == opens


def test_cubes_begin_on_the_robots_side_of_the_line_within_eight_centimetres() -> None:
    env = make("FetchAlign")
    starts = np.array([env.reset(seed=s)[0] for s in range(50)])
    away = 1.30 - starts[:, [9, 21, 33]]
    assert away.min() >= 0.05 - 1e-6
    assert away.max() <= 0.08 + 1e-6
    assert len(np.unique(away)) == 150
    np.testing.assert_allclose(starts[:, [11, 23, 35]], 0.425, atol=1e-6)


def test_what_is_seen_of_a_cube_is_seen_from_the_gripper() -> None:
    env = make("FetchAlign")
    seen = rollout(env, 0.3 * moves(15, seed=2), seed=0)
    bounds = env.observation_space
    seen = seen[((seen > bounds.low) & (seen < bounds.high))[:, :3].all(axis=1)]
    assert len(seen) > 8
    for start in (9, 21, 33):
        cube, away, velocity = (seen[:, start + k : start + k + 3] for k in (0, 3, 9))
        np.testing.assert_allclose(away, cube - seen[:, :3], atol=1e-6)
        if np.ptp(cube, axis=0).max() < 1e-6:  # it was not touched
            np.testing.assert_allclose(velocity, -seen[:, 3:6], atol=1e-6)


def test_a_tray_stands_in_about_half_of_the_episodes_and_can_be_had_always_or_never() -> None:
    seen = np.array([make("FetchPlaceTray").reset(seed=s)[0] for s in range(60)])
    present = seen[:, 27] > 0.5
    assert 20 <= present.sum() <= 40
    np.testing.assert_allclose(seen[~present][:, 25:27] - (1.05, 0.4), 0, atol=1e-6)
    assert (np.abs(seen[present][:, 26] - seen[present][:, 4]) > 0.105).all(), "beside the block"
    for tray in (True, False):
        env = make("FetchPlaceTray", tray=tray)
        assert {bool(env.reset(seed=s)[0][27]) for s in range(8)} == {tray}


def test_a_tray_is_solid_and_one_that_is_absent_is_not_there() -> None:
    heights = []
    for tray in (True, False):
        env = make("FetchPlaceTray", tray=tray)
        env.reset(seed=0)
        place = env.data.mocap_pos[env.model.body("tray").mocapid[0]]
        env.put("object0:joint", place[0], place[1], 0.5)
        for _ in range(15):
            seen = env.step(np.zeros(4))[0]
        heights.append(float(seen[5]))
    assert heights == pytest.approx([0.435, 0.425], abs=2e-3)


def test_pressing_the_button_draws_a_new_goal_once() -> None:
    env = make("FetchPlaceButton")
    seen, _ = env.reset(seed=0)
    goals = [seen[25:28]]
    for _ in range(25):
        to_go = seen[28:31] - seen[:3]
        seen = env.step(np.array([*np.clip(25 * to_go, -1, 1), 0.0]))[0]
        goals.append(seen[25:28])
    changes = [t for t in range(25) if (goals[t] != goals[t + 1]).any()]
    assert len(changes) == 1, "staying on the button draws no more"
    assert np.linalg.norm(seen[28:31] - seen[:3]) < 0.05
    for _ in range(5):
        seen = env.step(np.array([0, -1, 1, 0]))[0]
    assert (seen[25:28] == goals[-1]).all()


@every_task
def test_the_scene_from_above_shows_things_where_they_are(name: str) -> None:
    env = make(name)
    seen, _ = env.reset(seed=1)
    scene = env.scene()
    x, y = (float(seen[i]) for i in scene.position)
    assert scene.bounds[0] < x < scene.bounds[2]
    assert scene.bounds[1] < y < scene.bounds[3]
    for shape in scene.shapes:
        if shape.name == "block":
            middle = np.add(shape.low, shape.high) / 2
            np.testing.assert_allclose(middle, seen[3:5], atol=1e-6)
        if shape.name == "GoalReached":
            assert isinstance(shape, Circle)
            np.testing.assert_allclose(shape.center, seen[25:27], atol=1e-6)


@every_task
def test_before_a_reset_the_scene_shows_where_things_may_be(name: str) -> None:
    env = make(name)
    before = {shape.name: shape for shape in env.scene().shapes}
    for seed in range(5):
        env.reset(seed=seed)
        for shape in env.scene().shapes:
            around = before[shape.name]
            if isinstance(around, Circle):
                assert shape == around
                continue
            low, high = np.array(around.low) - 1e-6, np.array(around.high) + 1e-6
            middle = (
                shape.center if isinstance(shape, Circle) else np.add(shape.low, shape.high) / 2
            )
            if shape.name != "z":
                assert (low <= middle).all()
                assert (middle <= high).all()


@pytest.mark.slow
def test_the_grasp_that_is_seen_is_the_grasp_that_is_felt() -> None:
    """Agreement with the contacts of both fingers, over handling much worse than an expert's."""
    env, generator = make("FetchPlaceButton"), np.random.default_rng(0)
    felt, told = [], []
    for seed in range(24):
        noise = (0.0, 0.3, 0.8, 1.5)[seed % 4]
        expert = dataclasses.replace(experts_of(env)[0], noise=noise, laps=50)
        seen, _ = env.reset(seed=seed)
        progress, clumsy = expert.begin(seen, generator), 0
        for _ in range(120):
            action, progress = expert.act(seen, progress, generator)
            clumsy = clumsy - 1 if clumsy else int(generator.random() < 0.05) * 5
            if clumsy:
                action[3] = generator.uniform(-1, 1)
            seen = env.step(action)[0]
            felt.append(env.touched() and seen[5] > 0.445)
            near = np.linalg.norm(seen[6:9]) < 0.04
            told.append(near and seen[5] > 0.445 and seen[9:11].sum() < 0.052)
    both = np.array([felt, told], bool)
    assert both[0].mean() > 0.05
    assert (both[0] == both[1]).mean() > 0.995


def test_without_gymnasium_robotics_it_is_said_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from tiloilc.tasks.robots.fetch.arm import build

    monkeypatch.setattr("tiloilc.tasks.robots.fetch.arm.find_spec", lambda name: None)
    with pytest.raises(gym.error.DependencyNotInstalled, match="gymnasium-robotics"):
        build("push.xml", lambda spec: None)


def test_importing_the_tasks_imports_no_mujoco() -> None:
    code = "import sys, tiloilc.tasks; print([m for m in sys.modules if 'mujoco' in m])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
