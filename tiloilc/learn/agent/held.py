"""Steps that wait until their episode is over, for an algorithm that judges whole episodes."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from tiloilc.learn.algorithm.method import Episode, Method
from tiloilc.learn.engine.replay import Layout
from tiloilc.learn.engine.state import State
from tiloilc.product import Floats, Int


class Held:
    """Rows of a replay [seed, copy, width] in the order of steps, until all copies' are judged.

    So they enter the replay in order and for all seeds at once, an episode late at most.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.rows: list[Floats] = []
        self.arrived: list[Int] = []
        self.judged: list[NDArray[np.bool_]] = []

    def add(self, rows: Floats, arrived: Int) -> None:
        """A step of each copy; b' [seed, copy] is where it arrived."""
        self.rows.append(rows)
        self.arrived.append(arrived.copy())
        self.judged.append(np.zeros(arrived.shape, dtype=np.bool_))

    def finish(self, method: Method, over: NDArray[np.bool_], length: Int) -> Floats:
        """Judge the episodes of the copies in `over`; the rows [seed, n, width] now judged."""
        for seed, copy in np.argwhere(over):
            last = range(len(self.rows) - int(length[seed, copy]), len(self.rows))
            rows = np.stack([self.rows[t][seed, copy] for t in last])
            parts = self.layout.unpack(torch.from_numpy(rows)[None])
            arrived = np.array([self.arrived[t][seed, copy] for t in last])
            episode = Episode(parts.next_observation[0].numpy(), parts.state[0].numpy(), arrived)
            for t, kept in zip(last, method.judge(episode), strict=True):
                self.rows[t][seed, copy, -self.layout.kept :] = kept
                self.judged[t][seed, copy] = True
        done = next((t for t, judged in enumerate(self.judged) if not judged.all()), len(self.rows))
        seeds = over.shape[0]
        ready = [np.zeros((seeds, 0, self.layout.width), dtype=np.float32), *self.rows[:done]]
        self.rows, self.arrived = self.rows[done:], self.arrived[done:]
        self.judged = self.judged[done:]
        return np.concatenate(ready, axis=1)

    def state(self) -> State:
        """All that waits."""
        if not self.rows:
            return {}
        return {
            "rows": torch.from_numpy(np.stack(self.rows)),
            "arrived": torch.from_numpy(np.stack(self.arrived)),
            "judged": torch.from_numpy(np.stack(self.judged)),
        }

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.rows, self.arrived, self.judged = (
            list(state[name].numpy().copy()) if state else []
            for name in ("rows", "arrived", "judged")
        )
