"""SQIL: soft Q imitation learning (Reddy, Dragan and Levine, ICLR 2020).

Faithful: the reward is 1 on demonstrated steps and 0 on the agent's own, half of each batch is of
either kind (`demo_replay`), and the rest is ordinary soft Q-learning. Demonstrated steps need
actions: recorded ones, or such as are inferred from the agent's own steps.
"""

from __future__ import annotations

from torch import Tensor

from tiloilc.learn.algorithm.arrivals import Arrivals
from tiloilc.learn.engine.replay import Batch


class SQIL(Arrivals):
    """Doing what was shown pays 1."""

    doomed = False

    def extra(self, batch: Batch, options: Tensor) -> Tensor:
        """1 on demonstrated steps."""
        return batch.shown[..., None].float()
