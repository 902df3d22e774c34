"""Packed replay: one row a transition, one ring a seed, one gather a batch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State


@dataclass(frozen=True, slots=True)
class Batch:
    """Transitions of the product; each with leading axes [seed, n].

    `state` is b, before the step; `letter` is that of `next_observation`, so that the step can be
    read from any other automaton state as well; `terminal` marks an environment's own end. `kept`
    [seed, n, columns] is what the algorithm keeps of each; `shown` marks demonstrated ones.
    """

    observation: Tensor
    action: Tensor
    next_observation: Tensor
    state: Tensor
    letter: Tensor
    terminal: Tensor
    kept: Tensor
    shown: Tensor


@dataclass(frozen=True, slots=True)
class Layout:
    """Where the parts of a transition stand in its row, what is `kept` of it last."""

    observation: int
    action: int
    kept: int = 0

    @property
    def width(self) -> int:
        """Columns of a row."""
        return 2 * self.observation + self.action + 3 + self.kept

    def pack(
        self,
        observation: NDArray[np.float32],
        action: NDArray[np.float32],
        after: NDArray[np.float32],
        state: NDArray[np.int64],
        letter: NDArray[np.int64],
        terminal: NDArray[np.bool_],
    ) -> NDArray[np.float32]:
        """Rows [seed, n, width] of transitions with leading axes [seed, n]; 0 for what is kept."""
        rows = np.zeros((*state.shape, self.width), dtype=np.float32)
        columns = (state[..., None], letter[..., None], terminal[..., None])
        parts = (observation, action, after, *columns)
        start = 0
        for part in parts:
            rows[..., start : start + part.shape[-1]] = part
            start += part.shape[-1]
        return rows

    def unpack(self, rows: Tensor, shown: int = 0) -> Batch:
        """The parts of rows [seed, n, width]; the first `shown` are demonstrated ones."""
        d, m = self.observation, self.action
        observation, action, after, state, letter, terminal, kept = rows.split(
            [d, m, d, 1, 1, 1, self.kept], dim=-1
        )
        told = torch.arange(rows.shape[1], device=rows.device) < shown
        return Batch(
            observation,
            action,
            after,
            state.squeeze(-1).long(),
            letter.squeeze(-1).long(),
            terminal.squeeze(-1) > 0,
            kept,
            told.expand(rows.shape[:2]),
        )


class Replay:
    """A ring of `capacity` rows for each seed; all rings are equally full."""

    def __init__(
        self, seeds: int, capacity: int, width: int, device: torch.device | str = "cpu"
    ) -> None:
        self.rows = torch.zeros(seeds, capacity, width, device=device)
        self._starts = torch.arange(seeds, device=device)[:, None] * capacity
        self.written = 0

    def __len__(self) -> int:
        return min(self.written, self.rows.shape[1])

    def add(self, rows: NDArray[np.float32]) -> None:
        """Store rows [seed, k, width], over the oldest ones when full."""
        at = (self.written + np.arange(rows.shape[1])) % self.rows.shape[1]
        device = self.rows.device
        new = torch.from_numpy(rows).to(device, self.rows.dtype)
        self.rows.index_copy_(1, torch.from_numpy(at).to(device), new)
        self.written += rows.shape[1]

    def draw(self, count: int, generator: torch.Generator) -> Tensor:
        """Places [seed, count] for `at`: uniform with replacement, for each seed on its own."""
        shape = (self.rows.shape[0], count)
        drawn = torch.randint(len(self), shape, generator=generator, device=self.rows.device)
        return drawn + self._starts

    def at(self, places: Tensor) -> Tensor:
        """The rows [seed, n, width] at `places` [seed, n]."""
        flat = self.rows.flatten(0, 1).index_select(0, places.flatten())
        return flat.view(*places.shape, flat.shape[1])

    def sample(self, count: int, generator: torch.Generator) -> Tensor:
        """Rows [seed, count, width], drawn anew."""
        return self.at(self.draw(count, generator))

    def ring(self) -> Ring:
        """The rows; all seeds' are written alike."""
        return Ring(self.rows, torch.full((self.rows.shape[0],), self.written))

    def state(self) -> State:
        """Everything but the rows."""
        return {"written": torch.tensor(self.written)}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.written = int(state["written"])
