"""Doggo walks, and its corridor and discs are where the task files say."""

from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.tasks.acting import acted
from tests.tasks.robots.judge import rollout, shown, steady, task, visits
from tiloilc.tasks.robots import trot_search
from tiloilc.tasks.robots.doggo import JOINTS, DoggoAvoidEnv, DoggoEnv, DoggoNavigateEnv
from tiloilc.tasks.robots.trot import Trot, heading, shipped_trot, written

WORLDS = [DoggoAvoidEnv, DoggoNavigateEnv]
every_world = pytest.mark.parametrize("world", WORLDS)
every_task = pytest.mark.parametrize(
    ("name", "world"), list(zip(("doggo_avoid", "doggo_navigate"), WORLDS, strict=True))
)


def wild(steps: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (steps, 12)).astype(np.float32)


@every_world
def test_it_passes_gymnasiums_checker(world: type[DoggoEnv]) -> None:
    env = gym.make(f"tiloilc/{world.__name__.removesuffix('Env')}-v0", render_mode="rgb_array")
    check_env(env.unwrapped)
    env.close()


def test_an_observation_is_what_the_sensors_of_the_robot_say() -> None:
    env = DoggoNavigateEnv()
    seen = rollout(env, wild(30), seed=2)[-1]
    data = env.data

    def sensed(*names: str) -> list[float]:
        return [float(v) for name in names for v in data.sensor(name).data]

    angles = np.array([float(data.joint(joint).qpos[0]) for joint in JOINTS])
    feet = [f"touch_ankle_{leg}{end}" for leg in (1, 2, 3, 4) for end in "ab"]
    expected = [
        *sensed("accelerometer", "velocimeter", "gyro", "magnetometer"),
        *sensed(*feet),
        *sensed(*(f"jointvel_{joint}" for joint in JOINTS)),
        *np.sin(angles),
        *np.cos(angles),
        *data.joint("robot").qpos,
        *sensed("subtreecom"),
    ]
    low, high = env.observation_space.low, env.observation_space.high
    assert len(expected) == 66
    np.testing.assert_allclose(seen, np.clip(expected, low, high), rtol=1e-6)
    moving = data.joint("hip_1_z").qvel[0]
    assert seen[env.observation_fields["joint_velocity"]][0] == pytest.approx(moving, rel=1e-6)
    assert [env.model.actuator(i).name for i in range(12)] == list(JOINTS)


def test_fields_cover_the_observation() -> None:
    env = DoggoAvoidEnv()
    covered = np.concatenate([np.r_[place] for place in env.observation_fields.values()])
    assert covered.tolist() == list(range(66))
    assert env.step_seconds == pytest.approx(0.1)


def test_equal_seeds_and_actions_give_equal_bits() -> None:
    first, second = DoggoAvoidEnv(), DoggoAvoidEnv()
    rollout(second, wild(20, seed=9), seed=4)
    actions = wild(200)
    np.testing.assert_array_equal(
        rollout(first, actions, seed=3), rollout(second, actions, seed=3), strict=True
    )


def test_what_is_painted_on_the_floor_touches_nothing() -> None:
    actions = wild(200, seed=5)
    np.testing.assert_array_equal(
        rollout(DoggoAvoidEnv(), actions, seed=1), rollout(DoggoNavigateEnv(), actions, seed=1)
    )


def test_it_starts_in_the_origin_and_faces_along_the_corridor() -> None:
    env = DoggoAvoidEnv()
    starts = np.array([env.reset(seed=seed)[0] for seed in range(30)], np.float64)
    assert not starts[:, 56:58].any()
    headings = np.array([heading(row[59:63]) for row in starts])
    assert np.abs(headings).max() <= 0.1 + 1e-6
    assert headings.min() < -0.05
    assert headings.max() > 0.05
    assert len(np.unique(starts[:, 32])) == 30, "joints are drawn"


def corridor(observations: np.ndarray) -> np.ndarray:
    letters = []
    for row in observations:
        x, y = float(row[56]), float(row[57])
        outside = y > 0.8 or y < -0.8 or x < -0.5
        letters.append((x >= 4.0) + 2 * outside)
    return np.array(letters)


def discs(observations: np.ndarray) -> np.ndarray:
    letters = []
    for row in observations:
        x, y = float(row[56]), float(row[57])
        first = (x - 1.6) ** 2 + (y - 0.6) ** 2 < 0.25
        second = (x - 2.8) ** 2 + (y + 1.0) ** 2 < 0.25
        letters.append(first + 2 * second)
    return np.array(letters)


@pytest.mark.parametrize(("name", "ours"), [("doggo_avoid", corridor), ("doggo_navigate", discs)])
def test_predicates_say_what_the_zones_are(name: str, ours: object, root: Path) -> None:
    found = task(root, name)
    generator = np.random.default_rng(0)
    space = found.asked.observation_space
    states = generator.uniform(space.low, space.high, (10_000, 66))
    states[:, 56:58] = generator.uniform((-1, -2), (5, 2), (10_000, 2))
    states = states.astype(np.float32)
    letters = found.labels(states)
    np.testing.assert_array_equal(letters, ours(states))
    assert sorted(set(letters.tolist())) == (
        [0, 1, 2] if name == "doggo_navigate" else [0, 1, 2, 3]
    )


@every_task
def test_zones_are_drawn_where_the_predicates_hold(
    name: str, world: type[DoggoEnv], root: Path
) -> None:
    found, scene = task(root, name), world().scene()
    names = list(found.spec.propositions)
    assert {shape.name for shape in scene.shapes} == set(names)
    for shape in scene.shapes:
        low = getattr(shape, "low", None)
        state = np.zeros((1, 66), np.float32)
        state[0, list(scene.position)] = (
            shape.center if low is None else np.add(low, shape.high) / 2
        )
        assert found.labels(state)[0] >> names.index(shape.name) & 1


def test_the_gait_moves_diagonal_legs_together_and_steers_by_the_front() -> None:
    trot = shipped_trot()
    now, later = trot.torques(0.3, 0.0), trot.torques(0.3 + 0.5 / trot.frequency, 0.0)
    front_left, rear_left, rear_right, front_right = now.reshape(3, 4).T
    later_right = later.reshape(3, 4)[:, 3]
    np.testing.assert_allclose(front_left, later_right, atol=1e-12)
    np.testing.assert_allclose(rear_left, later.reshape(3, 4)[:, 2], atol=1e-12)
    assert np.abs(now).max() <= 1
    calm = Trot(1.0, trot.swings).torques(0.3, 0.0, vigour=0.0)
    turned = Trot(1.0, trot.swings).torques(0.3, 0.2, vigour=0.0) - calm
    np.testing.assert_allclose(turned.reshape(3, 4)[0], [0.2, 0, 0, -0.2], atol=1e-12)
    assert not turned[4:].any()
    assert rear_right.shape == front_right.shape == (3,)


def test_the_gait_survives_being_written() -> None:
    import json

    numbers = [float(n) for n in np.random.default_rng(0).standard_normal(19)]
    again = json.loads(written(Trot.of(numbers), seed=3))
    swings = [value for swing in again["swings"].values() for value in swing.values()]
    assert [again["frequency"], *swings] == numbers
    assert again["seed"] == 3


def test_equal_seeds_find_equal_gaits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trot_search, "CANDIDATES", 4)
    monkeypatch.setattr(trot_search, "BEST", 2)
    monkeypatch.setattr(trot_search, "STEPS", 5)
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        found = ["-o", str(tmp_path / name), "--rounds", "2", "--seed", seed]
        assert trot_search.main(found) == 0
    texts = [(tmp_path / name).read_text() for name in "abc"]
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


def test_the_shipped_gait_comes_along_both_courses_upright() -> None:
    assert trot_search.worth(DoggoAvoidEnv(), shipped_trot(), seed=77) > 2.5


@every_task
def test_the_expert_is_accepted(name: str, world: type[DoggoEnv], root: Path) -> None:
    env = world()
    found = task(root, name)
    reached = [visits(found, acted(env, steady(env), 500, seed)) > 0 for seed in range(5)]
    assert sum(reached) >= 4


@pytest.mark.slow
@every_task
@pytest.mark.parametrize("noise", [0.0, None])
def test_the_expert_is_accepted_in_nine_of_ten_episodes(
    name: str, world: type[DoggoEnv], noise: float | None, root: Path
) -> None:
    env = world()
    expert = steady(env) if noise == 0.0 else env.experts()[0]
    found = task(root, name)
    reached = [visits(found, acted(env, expert, 500, seed)) > 0 for seed in range(50)]
    assert sum(reached) >= 45


def test_the_best_that_is_known_starts_anew_and_goes_on_to_the_horizon() -> None:
    (known,) = DoggoAvoidEnv().known_best(3)
    assert known.observations.shape == (8, 4, 66)
    again = acted(DoggoAvoidEnv(), steady(DoggoAvoidEnv()), 3, seed=7)
    np.testing.assert_array_equal(known.observations[7], again)


@every_task
def test_the_demonstrations_are_accepted(name: str, world: type[DoggoEnv], root: Path) -> None:
    assert world.__name__
    runs = shown(root, name)
    assert len(runs) == 5
    assert all(visits > 0 and violates is None for visits, violates in runs)
