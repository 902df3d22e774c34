"""Which buffers of states feed which discriminator (paper, Algorithm 1, lines 17 and 18)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from tiloilc.plan import Stages


@dataclass(frozen=True, slots=True)
class Unions:
    """What discriminators are told: `positive` and `negative` [stage, buffer] of 0 and 1.

    `slot` [states] is the stage whose f judges in each automaton state; the number of stages where
    none does.
    """

    positive: Tensor
    negative: Tensor
    slot: Tensor

    @property
    def stages(self) -> int:
        """How many discriminators there are."""
        return len(self.positive)

    @property
    def buffers(self) -> int:
        """How many buffers there are."""
        return self.positive.shape[1]


def stage_unions(stages: Stages, separate: bool) -> Unions:
    """A discriminator for each automaton state short of acceptance, or one for all states.

    A state without positive buffers, such as acceptance and the sink, has none.
    """
    count = len(stages.index)
    if not separate:
        one = torch.zeros(1, stages.sink_buffer + 1, dtype=torch.long)
        one[0, [b for b, distance in enumerate(stages.distance) if distance == 0]] = 1
        return Unions(one, 1 - one, torch.zeros(count, dtype=torch.long))
    positive = torch.zeros(count, stages.sink_buffer + 1, dtype=torch.long)
    negative = torch.zeros_like(positive)
    for b in range(count):
        positive[b, list(stages.positive[b])] = 1
        negative[b, list(stages.negative[b])] = 1
    told = positive.any(1)
    slot = torch.where(told, told.cumsum(0) - 1, int(told.sum()))
    return Unions(positive[told], negative[told], slot)


def shown_and_own(states: int) -> Unions:
    """One discriminator for all states: buffer 0 holds what was shown, buffer 1 the agent's own."""
    sides = torch.eye(2, dtype=torch.long)
    return Unions(sides[:1], sides[1:], torch.zeros(states, dtype=torch.long))
