"""Which stage buffers feed which discriminator (paper, Algorithm 1, lines 17 and 18)."""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.plan import Stages


def stage_unions(stages: Stages, separate: bool) -> tuple[Tensor, Tensor]:
    """The buffers that feed each discriminator, as [stage, buffer] of 0 and 1."""
    positive = torch.zeros(len(stages.index), stages.sink_buffer + 1, dtype=torch.long)
    negative = torch.zeros_like(positive)
    for b in range(len(stages.index)):
        positive[b, list(stages.positive[b])] = 1
        negative[b, list(stages.negative[b])] = 1
    if separate:
        return positive, negative
    accepting = [b for b, distance in enumerate(stages.distance) if distance == 0]
    one = torch.zeros(1, stages.sink_buffer + 1, dtype=torch.long)
    one[0, accepting] = 1
    return one, 1 - one
