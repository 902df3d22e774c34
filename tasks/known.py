"""What is known to be possible in worlds that have no finite model: the best episodes that are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from tiloilc.tasks.experts import Expert, Observation


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """Episodes of one very good controller, made of real actions.

    observations  [m, T+1, d]  what was seen from m starts, equally likely, the first row included
    how           in words, for the reader of a result: who acted, and what nobody could exceed

    What they achieve is a lower bound of what can be. An environment does not know what counts as
    an achievement: that is asked of the observations.
    """

    observations: npt.NDArray[np.generic]
    how: str


def known_best(env: object, horizon: int) -> tuple[Known, ...]:
    """The best episodes of `horizon` steps that an environment publishes, one entry a controller.

    An environment publishes them by a method `known_best(horizon)` on its unwrapped form; empty if
    it has none. Raises TypeError if what it publishes is something else.
    """
    bare = getattr(env, "unwrapped", env)
    publish = getattr(bare, "known_best", None)
    if publish is None:
        return ()
    found = tuple(publish(horizon))
    for known in found:
        if not isinstance(known, Known):
            raise TypeError(f"{bare!r} publishes {type(known).__name__} as a known best")
    return found


def played(
    env: gymnasium.Env[Observation, Any], expert: Expert, horizon: int, starts: int, how: str
) -> Known:
    """What is seen while an expert acts for `horizon` steps, from the starts of seeds 0, 1, …

    The expert must not be done before that.
    """
    episodes = []
    for seed in range(starts):
        generator = np.random.default_rng(seed)
        observation, _ = env.reset(seed=seed)
        progress = expert.begin(observation, generator)
        seen = [observation]
        for _ in range(horizon):
            action, progress = expert.act(seen[-1], progress, generator)
            assert not progress.done, "the expert stops before the horizon"
            seen.append(env.step(action)[0])
        episodes.append(seen)
    return Known(np.array(episodes), how)
