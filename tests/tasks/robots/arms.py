"""The Fetch tasks, and what their propositions mean, written out one observation at a time."""

from collections.abc import Callable
from math import dist

import gymnasium as gym
import numpy as np

import tiloilc.tasks  # noqa: F401  registers them

NAMES = ("FetchAlign", "FetchAvoid", "FetchPlaceButton", "FetchPlaceTray")
SPECS = ("fetch_align", "fetch_avoid", "fetchplace_button", "fetchplace_tray")
IDS = dict(zip(SPECS, NAMES, strict=True))
DIMENSIONS = dict(zip(NAMES, (45, 10, 31, 28), strict=True))


def make(name: str, **kwargs: object) -> gym.Env:
    return gym.make(f"tiloilc/{name}-v0", disable_env_checker=True, **kwargs).unwrapped


def rollout(env: gym.Env, actions: np.ndarray, seed: int) -> np.ndarray:
    seen = [env.reset(seed=seed)[0]]
    seen += [env.step(action)[0] for action in actions]
    return np.array(seen)


def moves(steps: int, seed: int = 0) -> np.ndarray:
    """Actions that wander, downwards more than upwards, so that they meet what lies about."""
    generator = np.random.default_rng(seed)
    push = np.cumsum(generator.normal(0, 0.5, (steps, 4)), axis=0) % 4 - 2
    return np.clip(push - np.array((0, 0, 0.3, 0)), -1, 1)


def align(o: list[float]) -> list[bool]:
    return [abs(o[9 + 12 * i] - 1.30) < 0.03 for i in range(3)]


def avoid(o: list[float]) -> list[bool]:
    return [o[0] >= np.float32(1.70), abs(o[1] - 0.749) > 0.04]


def grasp(o: list[float]) -> bool:
    near = dist(o[6:9], (0, 0, 0)) < 0.04
    return near and o[5] > 0.445 and o[9] + o[10] < 0.052


def tray(o: list[float]) -> list[bool]:
    block, there = o[3:6], o[27] > 0.5
    inside = max(abs(block[0] - o[25]), abs(block[1] - o[26])) < 0.05
    goal = dist(block, (1.32, 0.56, 0.425)) < 0.05
    return [there, grasp(o), there and inside and block[2] < 0.46, goal]


def button(o: list[float]) -> list[bool]:
    return [grasp(o), dist(o[3:6], o[25:28]) < 0.05, dist(o[0:3], o[28:31]) < 0.05]


HAND: dict[str, Callable[[list[float]], list[bool]]] = {
    "fetch_align": align,
    "fetch_avoid": avoid,
    "fetchplace_button": button,
    "fetchplace_tray": tray,
}


def by_hand(spec: str, observations: np.ndarray) -> np.ndarray:
    """Letters [n], bit i for proposition i."""
    rows = [HAND[spec](row) for row in observations.astype(np.float64).tolist()]
    return np.array([sum(bit << i for i, bit in enumerate(row)) for row in rows])


def states(spec: str, count: int) -> np.ndarray:
    """Observations [count, d] in whose numbers propositions are decided, drawn about the limits."""
    generator = np.random.default_rng(0)
    space = make(IDS[spec]).observation_space
    rows = generator.uniform(space.low, space.high, (count, *space.shape))

    def about(place: np.ndarray, spread: float) -> np.ndarray:
        return place + generator.uniform(-spread, spread, np.shape(place))

    if spec == "fetch_align":
        rows[:, [9, 21, 33]] = about(np.full((count, 3), 1.3), 0.06)
    elif spec == "fetch_avoid":
        rows[:, 0] = about(np.full(count, 1.7), 0.1)
        rows[:, 1] = about(np.full(count, 0.749), 0.08)
    else:
        rows[:, 6:9] = about(np.zeros((count, 3)), 0.035)
        rows[:, 5] = about(np.full(count, 0.45), 0.03)
        rows[:, 9:11] = about(np.full((count, 2), 0.025), 0.005)
    if spec == "fetchplace_tray":
        rows[:, 25:27] = about(rows[:, 3:5], 0.07)
        rows[:, 27] = generator.random(count) < 0.5
        rows[::3, 3:6] = about(np.tile((1.32, 0.56, 0.425), (len(rows[::3]), 1)), 0.05)
    elif spec == "fetchplace_button":
        rows[:, 25:28] = about(rows[:, 3:6], 0.05)
        rows[:, 28:31] = about(rows[:, 0:3], 0.05)
    return rows.astype(np.float32)
