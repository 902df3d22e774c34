"""Eventual discounting: each accepting visit is worth less than the one before, however late it is.

Reward 1 for each arrival in an accepting state; γ discounts there and hardly anywhere else
(Voloshin, Verma and Yue, Eventual Discounting Temporal Logic Counterfactual Experience Replay,
ICML 2023).
"""

import torch

from tiloilc.learn.algorithm import Backup, Plain

ELSEWHERE = 0.999
"""The discount where nothing is accepted: 1 would leave waiting for ever as good as arriving."""


class EventualDiscounting(Plain):
    """Everything but what steps are worth is soft actor-critic's own."""

    def __init__(self, setup):
        super().__init__(setup)
        self.pay = torch.from_numpy(self.walk.accepting).float()
        self.discount = torch.where(self.pay > 0, self.settings.gamma, ELSEWHERE)
        self.discount *= torch.arange(self.walk.states) != self.walk.sink

    def worth(self, observation, options):
        """Arriving in each option pays at once, and what comes then is discounted."""
        return Backup(self.pay[options], self.discount[options])

    def backup(self, batch, options):
        """The same; after an environment's own end nothing comes."""
        worth = self.worth(batch.next_observation, options)
        return Backup(worth.pay, worth.discount * ~batch.terminal[..., None])
