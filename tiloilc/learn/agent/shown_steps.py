"""Demonstrated steps as a table learns them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from tiloilc.learn.agent.shown import Shown
from tiloilc.learn.agent.steps import Trail
from tiloilc.learn.engine.cells import Cells
from tiloilc.learn.engine.replay import Batch
from tiloilc.product import Floats, Int


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
        action = np.full(len(shown.state), -1)
        if shown.action is not None:
            action = shown.action.reshape(-1).astype(np.int64) - first
        self.trail = shown_trail(shown, action, kept, seeds)
        self.before, self.after = (
            torch.from_numpy(cells(seen.numpy()))
            for seen in (self.trail.batch.observation, self.trail.batch.next_observation)
        )

    def see(self, observation: Floats, action: Int, after: Floats) -> None:
        """Remember where the agents' actions [seed, copy] led."""
        before, to = (torch.from_numpy(self.cells(seen)) for seen in (observation, after))
        self.leads[self.seed, before, torch.from_numpy(action)] = to

    def known(self, seeds: Tensor) -> Trail:
        """The steps [seed, n] of all demonstrations; of `seeds` [seed] those are valid whose action
        is known.
        """
        trail = self.trail
        leads = self.leads[self.seed, self.before] == self.after[..., None]
        told = trail.batch.action >= 0
        action = torch.where(told, trail.batch.action, leads.int().argmax(-1))
        valid = (told | leads.any(-1)) & seeds[:, None]
        return Trail(replace(trail.batch, action=action), valid, trail.age)


def shown_trail(shown: Shown, action: Int, kept: Floats, seeds: int) -> Trail:
    """All steps of all demonstrations, for each of the seeds: [seed, n].

    `action` [n] are columns of the table, `kept` [n, columns] is what the algorithm keeps.
    """
    n = len(shown.state)
    everywhere = np.ones(n, dtype=np.bool_)
    age = np.concatenate([np.arange(length)[::-1] for length in shown.lengths])
    parts = (
        shown.observation,
        action,
        shown.next_observation,
        shown.state,
        shown.letter,
        ~everywhere,
        kept,
        everywhere,
        everywhere,
        age,
    )
    *batch, valid, ages = (torch.from_numpy(part).expand(seeds, *part.shape) for part in parts)
    return Trail(Batch(*batch), valid, ages)
