"""What happened in training since the last event."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.product import Int


@dataclass
class Tally:
    """What happened since the last event, for each seed."""

    episodes: Int
    visits: Int
    violations: Int
    occupancy: NDArray[np.int64]
    updates: Int
    losses: dict[str, Tensor]

    @classmethod
    def empty(cls, seeds: int, states: int) -> Tally:
        """Nothing has happened."""
        none = np.zeros(seeds, dtype=np.int64)
        occupancy = np.zeros((seeds, states), dtype=np.int64)
        return cls(none, none.copy(), none.copy(), occupancy, np.zeros(1, dtype=np.int64), {})

    def add_losses(self, losses: dict[str, Tensor]) -> None:
        """Add one update's losses [seed]; without any, nothing was learned."""
        if not losses:
            return
        for name, loss in losses.items():
            known = self.losses.get(name)  # on no GPU after resuming
            self.losses[name] = loss if known is None else known.to(loss.device) + loss
        self.updates += 1

    def event(self) -> dict[str, object]:
        """Means by episode and update, for the log; None for seeds without an ended episode."""
        ended = self.episodes.tolist()
        updates = max(int(self.updates[0]), 1)
        return {
            "visits": _ratios(self.visits, ended),
            "violations": _ratios(self.violations, ended),
            "stage_histogram": self.occupancy.tolist(),
            "losses": {n: (self.losses[n] / updates).tolist() for n in sorted(self.losses)},
        }

    def state(self) -> State:
        """All counts, for a checkpoint."""
        counts = {name: torch.from_numpy(getattr(self, name)) for name in _COUNTS}
        return {**counts, **with_prefix("losses", self.losses)}

    @classmethod
    def of(cls, state: State) -> Tally:
        """The tally that gave `state`."""
        counts = {name: state[name].numpy() for name in _COUNTS}
        return cls(**counts, losses=under("losses", state))


_COUNTS = ("episodes", "visits", "violations", "occupancy", "updates")


def _ratios(values: Int, ended: list[int]) -> list[float | None]:
    return [float(v) / n if n else None for v, n in zip(values, ended, strict=True)]
