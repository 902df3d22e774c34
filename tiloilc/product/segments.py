"""Episodes cut at accepting states, and the stage each segment reached (paper, section 3.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.plan import Stages, max_stage
from tiloilc.product.environment import Floats
from tiloilc.product.walk import Int, Walk


@dataclass(frozen=True, slots=True)
class Segment:
    """States on the way to acceptance [m, d], for stage buffer `buffer` of copy `copy`."""

    copy: int
    buffer: int
    observations: Floats


class Segmenter:
    """Collects the steps of each copy and hands out the segments as they end.

    The accepting state ends its segment and the next begins with the following state. A stay in
    acceptance is no segment of its own. With `cut=False` the whole episode is one segment.
    """

    def __init__(self, walk: Walk, stages: Stages, copies: int, horizon: int, d: int, cut: bool):
        self.walk, self.stages, self.cut = walk, stages, cut
        self.observations: Floats = np.zeros((copies, horizon + 1, d), dtype=np.float32)
        self.states: Int = np.zeros((copies, horizon + 1), dtype=np.int64)
        self.length: Int = np.zeros(copies, dtype=np.int64)
        self.start: Int = np.zeros(copies, dtype=np.int64)

    def arrive(self, observations: Floats, states: Int, mask: NDArray[np.bool_]) -> list[Segment]:
        """Note where the copies of `mask` are now; the segments that this ends."""
        rows = np.flatnonzero(mask)
        at = self.length[rows]
        self.observations[rows, at] = observations[rows]
        self.states[rows, at] = states[rows]
        self.length[rows] = at + 1
        if not self.cut:
            return []
        done = rows[self.walk.accepting[states[rows]]]
        return [segment for copy in done for segment in self._finish(int(copy))]

    def end(self, mask: NDArray[np.bool_]) -> list[Segment]:
        """The episodes of `mask` are over: their trailing segments."""
        copies = np.flatnonzero(mask)
        segments = [segment for copy in copies for segment in self._finish(int(copy))]
        self.length[copies] = self.start[copies] = 0
        return segments

    def _finish(self, copy: int) -> list[Segment]:
        first, last = int(self.start[copy]), int(self.length[copy])
        self.start[copy] = last
        states = self.states[copy, first:last]
        if len(states) == 0 or self._stays(copy, first, states):
            return []
        buffer, keep = max_stage(self.stages, states)
        return [Segment(copy, buffer, self.observations[copy, first : first + keep].copy())]

    def _stays(self, copy: int, first: int, states: Int) -> bool:
        """A lone accepting state after an accepting one is a stay, not a way to acceptance."""
        accepting = self.walk.accepting
        return bool(
            len(states) == 1
            and first > 0
            and accepting[states[0]]
            and accepting[self.states[copy, first - 1]]
        )

    def state(self) -> dict[str, NDArray[Any]]:
        """What is collected of unfinished episodes."""
        return {name: getattr(self, name) for name in _STATE}

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Take what `state` gave."""
        for name in _STATE:
            getattr(self, name)[...] = state[name]


_STATE = ("observations", "states", "length", "start")
