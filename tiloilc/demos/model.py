"""Demonstrations as values: the states that an expert passed through, perhaps its actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Floats: TypeAlias = npt.NDArray[np.float32]
Actions: TypeAlias = npt.NDArray[np.generic]
Letters: TypeAlias = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Demo:
    """One episode: `observations` [T+1, d], the first one included, and `actions` [T, …] or None.

    `actions[t]` led from `observations[t]` to `observations[t + 1]`.
    """

    observations: Floats
    actions: Actions | None = None

    def __post_init__(self) -> None:
        assert self.observations.ndim == 2, "observations are [T+1, d]"
        assert len(self.observations) >= 1, "an episode has a first state"
        assert self.actions is None or len(self.actions) == self.steps

    @property
    def steps(self) -> int:
        """Environment steps, T."""
        return len(self.observations) - 1

    def head(self, steps: int) -> Demo:
        """The first `steps` steps."""
        if steps >= self.steps:
            return self
        actions = None if self.actions is None else self.actions[:steps]
        return replace(self, observations=self.observations[: steps + 1], actions=actions)


@dataclass(frozen=True, slots=True, eq=False)
class DemoSet:
    """Demonstrations of one task.

    `meta` is what stands in the sidecar: schema version, environment, field names, seeds, versions.
    """

    episodes: tuple[Demo, ...]
    meta: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        assert len({demo.observations.shape[1] for demo in self.episodes}) <= 1

    def __len__(self) -> int:
        return len(self.episodes)

    @property
    def dimensions(self) -> int:
        """Components of an observation; 0 if there are no episodes."""
        return int(self.episodes[0].observations.shape[1]) if self.episodes else 0

    @property
    def has_actions(self) -> bool:
        """Whether every episode carries its actions."""
        return bool(self.episodes) and all(demo.actions is not None for demo in self.episodes)

    def take(self, count: int) -> DemoSet:
        """The first `count` episodes; the sidecar's lists follow."""
        meta = dict(self.meta)
        for key in ("seeds", "steps"):
            if isinstance(meta.get(key), list):
                meta[key] = meta[key][:count]
        return DemoSet(self.episodes[:count], meta)

    def cut(self, steps: Sequence[int]) -> DemoSet:
        """The first `steps[i]` steps of episode i; the sidecar follows."""
        episodes = tuple(d.head(n) for d, n in zip(self.episodes, steps, strict=True))
        meta = dict(self.meta)
        if "steps" in meta:
            meta["steps"] = [demo.steps for demo in episodes]
        return DemoSet(episodes, meta)

    def without_actions(self) -> DemoSet:
        """States only, as in the paper."""
        return DemoSet(tuple(Demo(demo.observations) for demo in self.episodes), self.meta)
