"""A bundled task file with its predicates, its automaton and its shipped demonstrations."""

from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np

from tiloilc.demos import bundled, replay_all
from tiloilc.driver.analysis import Analysis, analyse
from tiloilc.tasks import Expert, experts_of


def task(root: Path, name: str) -> Analysis:
    found = analyse(root / "specs" / f"{name}.yaml")
    assert not found.failed
    return found


def visits(found: Analysis, observations: np.ndarray) -> int:
    """Accepting visits of an episode by the automaton; none once it is in a sink."""
    assert found.ldba is not None
    assert found.labels is not None
    run = found.ldba.run(found.labels(observations).tolist())
    return 0 if found.ldba.sink in run else sum(b in found.ldba.accepting for b in run[1:])


def shown(root: Path, name: str) -> list[tuple[int, int | None]]:
    """Accepting visits of each bundled demonstration, and where it violates."""
    found, demos = task(root, name), bundled(name)
    assert demos is not None
    assert found.ldba is not None
    assert found.labels is not None
    _, replays = replay_all(demos, found.labels, found.ldba)
    return [(run.visits, run.violates_at) for run in replays]


def rollout(env: gym.Env, actions: np.ndarray, seed: int) -> np.ndarray:
    seen = [env.reset(seed=seed)[0]]
    seen += [env.step(action)[0] for action in actions]
    return np.array(seen)


def steady(env: gym.Env, **changes: object) -> Expert:
    """The environment's first expert without noise."""
    return replace(experts_of(env)[0], noise=0.0, **changes)  # type: ignore[type-var]
