"""Discriminators of finite tasks, by counting (paper, section 3.2; Algorithm 1, lines 15-19)."""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.algorithm.unions import stage_unions
from tiloilc.plan import Stages
from tiloilc.product import Int
from tiloilc.spec.settings import Settings

SMOOTHING = 0.5
"""Added to every count: a state that neither side has seen gets f = 0."""


class CountDiscriminators:
    """f_b in closed form: on a table the best logit is the log-ratio of the two frequencies.

    `counts` [seed, buffer, observation] holds how often each state is in each stage buffer.
    """

    def __init__(self, stages: Stages, cells: int, shown: Int, settings: Settings) -> None:
        self.settings = settings
        self.positive, self.negative = stage_unions(stages, settings.stages)
        self.counts = torch.zeros(
            settings.seeds, stages.sink_buffer + 1, cells, dtype=torch.float64
        )
        self.demonstrations = torch.bincount(torch.from_numpy(shown), minlength=cells).double()
        self.values = torch.zeros(settings.seeds, len(self.positive), cells)

    def refresh(self) -> None:
        """Bring tanh f up to date with the counts, for every stage and cell."""
        own = torch.einsum("kb,sbc->skc", self.positive.double(), self.counts)
        negative = torch.einsum("kb,sbc->skc", self.negative.double(), self.counts)
        positive = _mix(own, self.demonstrations, self.settings.demo_fraction)
        scale = positive.sum(-1, keepdim=True).clamp(min=1)
        other = negative.sum(-1, keepdim=True)
        ratio = (positive + SMOOTHING) / (negative * scale / other.clamp(min=1) + SMOOTHING)
        known = (positive.sum(-1, keepdim=True) > 0) & (other > 0)
        known &= self.positive.any(1)[:, None]
        self.values = torch.where(known, torch.tanh(ratio.log()), 0.0).float()

    def bonus(self, seed: Tensor, cell: Tensor, state: Tensor) -> Tensor:
        """tanh f_b(s) for seeds, cells and automaton states of one shape, or broadcast to it."""
        stage = state if self.settings.stages else torch.zeros_like(state)
        return self.values[seed, stage, cell]


def _mix(own: Tensor, shown: Tensor, share: float) -> Tensor:
    """Counts of which `share` come from demonstrations, as far as there are both."""
    total, demos = own.sum(-1, keepdim=True), shown.sum()
    if demos == 0:
        return own
    weight = torch.where(total > 0, share * total.clamp(min=1) / demos, 1.0)
    return own * torch.where(total > 0, 1 - share, 0.0) + shown * weight
