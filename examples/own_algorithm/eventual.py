"""Eventual discounting: each accepting visit is worth less than the one before, however late it is.

Reward 1 for each arrival in an accepting state; γ discounts there and hardly anywhere else
(Voloshin, Verma and Yue, Eventual Discounting Temporal Logic Counterfactual Experience Replay,
ICML 2023).
"""

import torch

from tiloilc.learn.algorithm import Plain

ELSEWHERE = 0.999
"""The discount where nothing is accepted: 1 would leave waiting for ever as good as arriving."""


class EventualDiscounting(Plain):
    """Everything but the target is soft actor-critic's own."""

    def __init__(self, setup):
        super().__init__(setup)
        self.accepting = torch.from_numpy(self.walk.accepting)

    def worth(self, observation, options, value):
        """Arriving in each option pays at once, and what comes then is discounted."""
        arrived = self.accepting[options]
        later = torch.where(arrived, self.settings.gamma, ELSEWHERE) * value
        return arrived.float() + later.where(options != self.walk.sink, 0.0)

    def target(self, batch, options, value):
        """The best of the options; an environment that has ended pays once more, at most."""
        over = batch.terminal[..., None]
        worth = self.worth(batch.next_observation, options, value)
        return torch.where(over, self.accepting[options].float(), worth).amax(-1)
