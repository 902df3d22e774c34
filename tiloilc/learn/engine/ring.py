"""Rings of rows: what was written since a checkpoint is all that the next one has to hold."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True, slots=True)
class Ring:
    """`rows` [ring, capacity, width], each ring filled in turn, over its oldest rows when full.

    `written` [ring] counts the rows that each was ever given. Both are the owner's own tensors.
    """

    rows: Tensor
    written: Tensor

    def since(self, before: Tensor) -> Tensor:
        """The rows [n, width] written since `written` was `before`, as far as still there."""
        places = self._places(before, self.written.cpu())
        return self.rows.reshape(-1, self.rows.shape[2])[places.to(self.rows.device)]

    def restore(self, rows: Tensor, before: Tensor, after: Tensor) -> None:
        """Put back what `since(before)` gave when `written` was `after`."""
        places = self._places(before, after).to(self.rows.device)
        self.rows.view(-1, self.rows.shape[2])[places] = rows.to(self.rows.device)

    def held(self, before: Tensor, after: Tensor) -> Tensor:
        """How many rows of each ring `since` gives, [ring]."""
        return (after - before).clamp(max=self.rows.shape[1])

    def _places(self, before: Tensor, after: Tensor) -> Tensor:
        """Where they stand when all rings are one list: ring after ring, the oldest first."""
        count = self.held(before, after)
        ring = torch.arange(len(count)).repeat_interleave(count)
        nth = torch.arange(int(count.sum())) - (count.cumsum(0) - count)[ring]
        capacity = self.rows.shape[1]
        return ring * capacity + ((after - count)[ring] + nth) % capacity
