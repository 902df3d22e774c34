"""Discriminators of finite tasks, by counting (paper, section 3.2; Algorithm 1, lines 15-19)."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from tiloilc.learn.algorithm.discriminator.unions import Unions
from tiloilc.learn.engine.cells import Cells
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State
from tiloilc.product import Floats
from tiloilc.spec.settings import Settings

SMOOTHING = 0.5
"""Added to every count: a state that neither side has seen gets f = 0."""


class CountDiscriminators:
    """f_b in closed form: on a table the best logit is the log-ratio of the two frequencies.

    `counts` [seed, buffer, cell] holds how often each state is in each buffer, `values`
    [seed, stage + 1, cell] are tanh f, the last ones 0. `demonstrations` [k, d] are states that got
    somewhere.
    """

    def __init__(
        self, unions: Unions, cells: Cells, demonstrations: Tensor, settings: Settings
    ) -> None:
        self.settings, self.cells = settings, cells
        self.unions, self.stages = unions, unions.stages
        count = cells.count
        self.counts = torch.zeros(settings.seeds, unions.buffers, count, dtype=torch.float64)
        self.demonstrations = self._tally(demonstrations.numpy()).double()
        self.values = torch.zeros(settings.seeds, self.stages + 1, count)
        self.seed = torch.arange(settings.seeds)[:, None]

    def see(self, after: Floats) -> None:
        """Counts need no scale."""

    def add(self, seed: int, buffer: int, observations: Floats) -> None:
        """Count a segment's states [m, d]."""
        self.counts[seed, buffer] += self._tally(observations)

    def draw(self) -> State:
        """Nothing is random."""
        return {}

    def learn(self, chance: State) -> dict[str, Tensor]:
        """Bring tanh f up to date with the counts, for every stage and cell."""
        own = torch.einsum("kb,sbc->skc", self.unions.positive.double(), self.counts)
        negative = torch.einsum("kb,sbc->skc", self.unions.negative.double(), self.counts)
        positive = _mix(own, self.demonstrations, self.settings.demo_fraction)
        scale = positive.sum(-1, keepdim=True).clamp(min=1)
        other = negative.sum(-1, keepdim=True)
        ratio = (positive + SMOOTHING) / (negative * scale / other.clamp(min=1) + SMOOTHING)
        known = (positive.sum(-1, keepdim=True) > 0) & (other > 0)
        self.values[:, :-1] = torch.where(known, torch.tanh(ratio.log()), 0.0).float()
        return {}

    def bonus(self, observation: Tensor, state: Tensor) -> Tensor:
        """tanh f_b(s) for s [seed, n, d] and b [seed, n]; 0 where b has no f."""
        cell = torch.from_numpy(self.cells(observation.numpy()))
        return self.values[self.seed, self.unions.slot[state], cell]

    def rings(self) -> dict[str, Ring]:
        """None: counts are kept instead of rows."""
        return {}

    def policy(self) -> State:
        """What f needs; the first axis counts seeds."""
        return {"values": self.values}

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.values.copy_(state["values"])

    def state(self) -> State:
        """Everything."""
        return {"counts": self.counts, **self.policy()}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.counts.copy_(state["counts"])
        self.load_policy(state)

    def _tally(self, observations: Floats) -> Tensor:
        """How often each cell is among states [m, d]."""
        number = np.bincount(self.cells(observations), minlength=self.cells.count)
        return torch.from_numpy(number)


def _mix(own: Tensor, shown: Tensor, share: float) -> Tensor:
    """Counts of which `share` come from demonstrations, as far as there are both."""
    total, demos = own.sum(-1, keepdim=True), shown.sum()
    if demos == 0:
        return own
    weight = torch.where(total > 0, share * total.clamp(min=1) / demos, 1.0)
    return own * torch.where(total > 0, 1 - share, 0.0) + shown * weight
