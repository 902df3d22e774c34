"""What all MuJoCo tasks share, on the smallest one there can be."""

import os
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.tasks.robots.slider import SliderEnv


def test_it_passes_gymnasiums_checker() -> None:
    env = SliderEnv(render_mode="rgb_array")
    check_env(env, skip_render_check=True)  # that one looks for a registered id
    env.close()


def test_fields_are_laid_out_one_after_the_other() -> None:
    env = SliderEnv()
    assert env.observation_fields == {"pos": slice(0, 3), "vx": 3}
    np.testing.assert_array_equal(env.observation_space.low, [-1, -1, 0, -2])
    assert env.step_seconds == pytest.approx(0.01)


def test_what_leaves_its_bounds_is_seen_at_the_bound() -> None:
    env = SliderEnv()
    env.reset(seed=0)
    for _ in range(400):
        seen = env.step(np.array([1.0]))[0]
    assert seen.dtype == np.float32
    assert seen[0] == 1
    assert env.data.qpos[0] > 1
    assert env.observation_space.contains(seen)


def test_equal_seeds_and_actions_give_equal_bits_whatever_happened_before() -> None:
    actions = np.random.default_rng(0).uniform(-1, 1, (50, 1))
    fresh, used = SliderEnv(), SliderEnv()
    used.reset(seed=5)
    for action in actions[::-1]:
        used.step(action)
    seen = []
    for env in (fresh, used):
        rows = [env.reset(seed=3)[0]]
        rows += [env.step(action)[0] for action in actions]
        seen.append((np.array(rows), env.data.qpos.copy()))
    np.testing.assert_array_equal(seen[0][0], seen[1][0])
    np.testing.assert_array_equal(seen[0][1], seen[1][1])
    assert not np.array_equal(fresh.reset()[0], used.reset(seed=3)[0]), "seeds are taken"


@pytest.mark.parametrize("wrong", [np.zeros(2), np.zeros((1, 1)), np.array([np.nan])])
def test_what_is_no_action_is_refused(wrong: np.ndarray) -> None:
    env = SliderEnv()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="an action must"):
        env.step(wrong)


def test_greater_actions_count_as_the_greatest() -> None:
    ends = []
    for push in (1.0, 7.0):
        env = SliderEnv()
        env.reset(seed=0)
        ends.append(env.step(np.array([push]))[0])
    np.testing.assert_array_equal(*ends)


def test_before_the_first_reset_there_is_nothing() -> None:
    env = SliderEnv(render_mode="rgb_array")
    with pytest.raises(gym.error.ResetNeeded):
        env.step(np.zeros(1))
    with pytest.raises(gym.error.ResetNeeded):
        env.render()
    with pytest.raises(ValueError, match="render_mode"):
        SliderEnv(render_mode="human")


def test_without_a_render_mode_there_is_no_picture() -> None:
    env = SliderEnv()
    env.reset(seed=0)
    assert env.render() is None


DRAW = """
import sys
from tests.tasks.robots.slider import SliderEnv
envs = [SliderEnv(render_mode="rgb_array") for _ in range(2)]
frames = []
for env in envs:
    env.reset(seed=0)
    frames.append(env.render())
    env.step([1.0])
    frames.append(env.render())
assert all(frame.dtype == "uint8" for frame in frames)
assert (frames[0] == frames[2]).all(), "both see the same"
assert frames[0].std() > 5, "there is something to be seen"
envs[0].close()
print(*frames[0].shape)
"""


@pytest.mark.parametrize(
    ("setting", "shape"),
    [
        ({}, None),
        ({"MUJOCO_GL": "disabled"}, "256 256 3"),
        ({"MUJOCO_GL": "egl", "MUJOCO_EGL_DEVICE_ID": "77"}, "256 256 3"),
        ({"__EGL_VENDOR_LIBRARY_FILENAMES": "/dev/null"}, "256 256 3"),
        ({"MUJOCO_GL": "osmesa"}, None),
    ],
)
def test_pictures_are_drawn_somehow_whatever_graphics_there_are(
    setting: dict[str, str], shape: str | None
) -> None:
    kept = {k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", DRAW],
        env={**kept, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p), **setting},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.strip() in ({shape} if shape else {"256 256 3", "480 480 3"})
