"""Experts at work."""

import gymnasium as gym
import numpy as np

from tiloilc.tasks import Expert


def acted(env: gym.Env, expert: Expert, horizon: int, seed: int) -> np.ndarray:
    """What is seen while an expert acts, until it is done."""
    generator = np.random.default_rng(seed)
    observation, _ = env.reset(seed=seed)
    progress = expert.begin(observation, generator)
    seen = [observation]
    for _ in range(horizon):
        action, progress = expert.act(observation, progress, generator)
        if progress.done:
            break
        assert env.action_space.contains(action)
        observation = env.step(action)[0]
        seen.append(observation)
    return np.array(seen)
