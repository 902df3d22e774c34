"""Cheetah flips: HalfCheetah's physics, its pitch as an angle that goes round, its planner."""

from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.tasks.acting import acted
from tests.tasks.robots.judge import rollout, shown, steady, task, visits
from tiloilc.tasks import Circle
from tiloilc.tasks.robots import flip_best
from tiloilc.tasks.robots.cheetah import CheetahFlipEnv, rotations


def wild(steps: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (steps, 6)).astype(np.float32)


def test_it_passes_gymnasiums_checker() -> None:
    env = gym.make("tiloilc/CheetahFlip-v0", render_mode="rgb_array")
    check_env(env.unwrapped)
    env.close()


def test_its_physics_is_half_cheetahs() -> None:
    ours = CheetahFlipEnv()
    theirs = gym.make("HalfCheetah-v5").unwrapped
    ours.reset(seed=0)
    theirs.reset(seed=0)
    ours.data.qpos[:], ours.data.qvel[:] = theirs.data.qpos, theirs.data.qvel
    for action in wild(50):
        ours.step(action)
        theirs.step(action)
    np.testing.assert_allclose(ours.data.qpos, theirs.data.qpos, rtol=1e-9, atol=1e-9)


def test_an_observation_is_half_cheetahs_with_the_pitch_as_cosine_and_sine() -> None:
    env = CheetahFlipEnv()
    seen = rollout(env, wild(40), seed=1)[-1]
    position, velocity = env.data.qpos, env.data.qvel
    pitch = [np.cos(position[2]), np.sin(position[2])]
    expected = [position[1], *pitch, *position[3:], *velocity]
    np.testing.assert_allclose(seen, np.array(expected), rtol=1e-6)
    covered = np.concatenate([np.r_[place] for place in env.observation_fields.values()])
    assert covered.tolist() == list(range(18))
    assert env.step_seconds == pytest.approx(0.05)


def test_equal_seeds_and_actions_give_equal_bits() -> None:
    first, second = CheetahFlipEnv(), CheetahFlipEnv()
    rollout(second, wild(20, seed=9), seed=4)
    actions = wild(300)
    np.testing.assert_array_equal(
        rollout(first, actions, seed=3), rollout(second, actions, seed=3), strict=True
    )


def test_it_starts_as_half_cheetah_does() -> None:
    env = CheetahFlipEnv()
    starts = []
    for seed in range(200):
        env.reset(seed=seed)
        starts.append((env.data.qpos.copy(), env.data.qvel.copy()))
    positions, velocities = (np.array(rows) for rows in zip(*starts, strict=True))
    assert np.abs(positions).max() <= 0.1
    assert positions.std() == pytest.approx(0.1 / 3**0.5, rel=0.1)
    assert velocities.std() == pytest.approx(0.1, rel=0.1)


def stands(observations: np.ndarray) -> np.ndarray:
    """By degrees instead of radians, and round the circle by hand."""
    letters = []
    for row in observations:
        degrees = np.degrees(np.arctan2(float(row[2]), float(row[1]))) % 360
        window = np.degrees(0.5)
        letters.append((abs(degrees - 90) < window) + 2 * (abs(degrees - 270) < window))
    return np.array(letters)


def test_predicates_say_what_a_stand_is(root: Path) -> None:
    found = task(root, "cheetah_flip")
    generator = np.random.default_rng(0)
    space = found.asked.observation_space
    states = generator.uniform(space.low, space.high, (10_000, 18))
    turn = generator.uniform(-np.pi, np.pi, 10_000)
    states[:, 1], states[:, 2] = np.cos(turn), np.sin(turn)
    states = states.astype(np.float32)
    letters = found.labels(states)
    np.testing.assert_array_equal(letters, stands(states))
    assert sorted(set(letters.tolist())) == [0, 1, 2]


def test_on_the_dial_zones_are_drawn_where_the_predicates_hold(root: Path) -> None:
    found, scene = task(root, "cheetah_flip"), CheetahFlipEnv().scene()
    zones = {s.name: s for s in scene.shapes if not isinstance(s, Circle)}
    assert list(zones) == ["b", "d"]
    turn = np.linspace(-np.pi, np.pi, 5_001)
    states = np.zeros((len(turn), 18), np.float32)
    states[:, scene.position[0]], states[:, scene.position[1]] = np.cos(turn), np.sin(turn)
    letters = found.labels(states)
    for i, zone in enumerate(zones.values()):
        dial = states[:, list(scene.position)]
        inside = ((dial >= zone.low) & (dial <= zone.high)).all(axis=1)
        assert (inside == (letters >> i & 1)).mean() > 0.999


def test_full_turns_are_counted_forwards() -> None:
    turn = np.linspace(0.3, 0.3 + 7.5 * 2 * np.pi, 200)
    seen = np.zeros((2, 200, 18))
    seen[..., 1], seen[..., 2] = np.cos(turn), np.sin(turn)
    seen[1] = seen[1, ::-1]
    counted = rotations(seen)
    assert counted.shape == (2, 200)
    np.testing.assert_allclose(counted[:, -1], [7.5, -7.5])
    assert not counted[:, 0].any()


def test_the_planner_flips_as_often_as_it_is_counted(root: Path) -> None:
    env, found = CheetahFlipEnv(), task(root, "cheetah_flip")
    seen = acted(env, steady(env, laps=99), 100, seed=0)
    assert visits(found, seen) >= 5
    start = env.reset(seed=0)[0]
    turned = (env.data.qpos[2], np.arctan2(start[2], start[1]))
    assert turned[0] == pytest.approx(turned[1], abs=1e-6)
    assert rotations(seen)[-1] >= 4.5


def test_the_planner_is_a_function_of_what_it_is_given() -> None:
    env = CheetahFlipEnv()
    expert = steady(env)
    observation, _ = env.reset(seed=0)
    progress = expert.begin(observation, np.random.default_rng(0))
    action, after = expert.act(observation, progress, np.random.default_rng(1))
    later = env.step(action)[0]
    expert.act(later, after, np.random.default_rng(2))
    again, _ = expert.act(observation, progress, np.random.default_rng(1))
    np.testing.assert_array_equal(action, again)


def test_the_best_that_is_known_is_of_real_steps_and_better_than_the_expert(root: Path) -> None:
    env, found = CheetahFlipEnv(), task(root, "cheetah_flip")
    (known,) = env.known_best(1000)
    (episode,) = known.observations
    assert episode.shape == (1001, 18)
    np.testing.assert_allclose(episode[0], env.reset(seed=0)[0], atol=1e-6)
    turned = np.diff(rotations(episode)) * 2 * np.pi
    before, after = episode[:-1, 11], episode[1:, 11]
    np.testing.assert_allclose(turned, env.step_seconds * (before + after) / 2, atol=0.5)
    assert visits(found, episode) >= 80
    (short,) = env.known_best(100)
    np.testing.assert_array_equal(short.observations[0], episode[:101])
    assert env.known_best(1001) == ()


def test_the_patient_planner_writes_what_it_does(tmp_path: Path) -> None:
    for name in ("a.npy", "b.npy"):
        assert flip_best.main(["-o", str(tmp_path / name), "--steps", "3"]) == 0
    assert (tmp_path / "a.npy").read_bytes() == (tmp_path / "b.npy").read_bytes()
    written = np.load(tmp_path / "a.npy", allow_pickle=False)
    np.testing.assert_allclose(written[:2], flip_best.shipped_flips()[:2], atol=1e-4)


@pytest.mark.slow
def test_the_planner_makes_five_visits_in_a_hundred_steps(root: Path) -> None:
    env, found = CheetahFlipEnv(), task(root, "cheetah_flip")
    expert = steady(env, laps=99)
    made = [visits(found, acted(env, expert, 100, seed)) for seed in range(50)]
    assert np.mean(made) >= 5
    assert min(made) >= 4


def test_the_demonstrations_are_two_flips_each(root: Path) -> None:
    runs = shown(root, "cheetah_flip")
    assert len(runs) == 5
    assert all(visits == 2 and violates is None for visits, violates in runs)
