"""Demonstrated steps as a table learns them."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from tiloilc.learn.agent.shown import Shown
from tiloilc.learn.agent.steps import Steps
from tiloilc.learn.engine.cells import Cells
from tiloilc.learn.engine.replay import Batch
from tiloilc.product import Floats


class ShownSteps:
    """All demonstrations side by side, step by step; their actions are recorded, or found out.

    Where none are recorded, the action is one that has led from the same cell to the same cell.
    Until an agent has seen one, it does not learn that step. Of finite environments it is enough to
    remember where each action led the last time: `leads` [seed, cell, action], -1 for nowhere yet.
    `kept` [n, columns] is what the algorithm keeps of the steps, `first` the number of the first of
    the `actions`.
    """

    def __init__(
        self, shown: Shown, kept: Floats, cells: Cells, seeds: int, actions: int, first: int
    ) -> None:
        self.cells = cells
        self.leads = torch.full((seeds, cells.count, actions), -1)
        self.seed = torch.arange(seeds)[:, None]
        self.longest = max(shown.lengths)
        action = (
            np.full((len(shown.state), 1), -1) if shown.action is None else shown.action - first
        )
        self.action = self._side_by_side(shown, action).squeeze(-1).long()
        self.observation = self._side_by_side(shown, shown.observation)
        self.after = self._side_by_side(shown, shown.next_observation)
        self.state = self._side_by_side(shown, shown.state)
        self.letter = self._side_by_side(shown, shown.letter)
        self.kept = self._side_by_side(shown, kept)
        self.valid = self._side_by_side(shown, np.ones(len(shown.state), dtype=np.bool_))

    def see(self, observation: Tensor, action: Tensor, after: Tensor) -> None:
        """Remember where the agents' actions [seed, copy] led."""
        self.leads[self.seed, self.cells(observation), action] = self.cells(after)

    def backwards(self) -> list[Steps]:
        """The steps [seed, demonstration], the last ones first; those known are valid."""
        return [self._step(t) for t in reversed(range(self.longest))]

    def _step(self, t: int) -> Steps:
        seeds, shown = len(self.leads), self.state.shape[0]
        observation, after = (
            rows[:, t].expand(seeds, -1, -1) for rows in (self.observation, self.after)
        )
        leads = self.leads[self.seed, self.cells(observation)] == self.cells(after)[..., None]
        action = self.action[:, t].expand(seeds, -1)
        known = self.valid[:, t] & ((action >= 0) | leads.any(-1))
        action = torch.where(action >= 0, action, leads.int().argmax(-1))
        state, letter = (rows[:, t].expand(seeds, -1) for rows in (self.state, self.letter))
        kept = self.kept[:, t].expand(seeds, -1, -1)
        never = torch.zeros(seeds, shown, dtype=torch.bool)
        batch = Batch(observation, action, after, state, letter, never, kept, ~never)
        return Steps(batch, known, state)

    def _side_by_side(self, shown: Shown, rows: np.ndarray) -> Tensor:
        """Rows [n, …] of all demonstrations as [demonstration, step, …], filled up with zeros."""
        padded = np.zeros((len(shown.lengths), self.longest, *rows.shape[1:]), dtype=rows.dtype)
        first = 0
        for place, length in zip(padded, shown.lengths, strict=True):
            place[:length] = rows[first : first + length]
            first += length
        return torch.from_numpy(padded)
