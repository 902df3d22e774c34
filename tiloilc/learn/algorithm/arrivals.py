"""What baselines have in common: a step pays for where it arrives, then comes the rest."""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.algorithm.method import Backup, Plain, Setup
from tiloilc.learn.engine.replay import Batch


class Arrivals(Plain):
    """A method whose target is r + Γ · V(s', b') of the best option b'.

    r is of the state arrived in, `pays` [states], and so is Γ, `discounts` [states]; what else a
    step pays is `extra`. `doomed` says whether the method knows that a sink is worth nothing: then
    V does not count there, else it is learned as elsewhere.
    """

    doomed = True

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        device = setup.generator.device
        self.accepting = torch.from_numpy(setup.walk.accepting).to(device)
        sink = torch.arange(setup.walk.states, device=device) == setup.walk.sink
        self.alive = ~sink if self.doomed else torch.ones_like(sink)
        self.pays = torch.zeros(setup.walk.states, device=device)
        self.discounts = self.alive * self.settings.gamma

    def arrive(self, options: Tensor) -> Backup:
        """What arriving in each option [seed, n, K] pays, and the discount Γ of what comes then."""
        return Backup(self.pays[options], self.discounts[options])

    def extra(self, batch: Batch, options: Tensor) -> Tensor:
        """What else a step pays, [seed, n, K] or [seed, n, 1]: by where it began, for instance."""
        return torch.zeros((*batch.state.shape, 1), device=options.device)

    def backup(self, batch: Batch, options: Tensor) -> Backup:
        """r + Γ · V(s', b'); nothing comes after an environment's own end."""
        costly = self.walk.costly  # to jump is a matter of the next step
        arrived = options[..., :1] if costly else options
        now = self.arrive(arrived)
        pay = now.pay + self.extra(batch, arrived)
        discount = now.discount * ~batch.terminal[..., None]
        if not costly:
            return Backup(pay, discount)
        then = self.worth(batch.next_observation, options)
        return Backup(pay + discount * then.pay, discount * then.discount)

    def worth(self, observation: Tensor, options: Tensor) -> Backup:
        """The same, as far as it depends on the option."""
        arrival = self.arrive(options)
        if not self.walk.costly:
            return arrival
        stays = options == options[..., :1]
        return Backup(arrival.pay.masked_fill(stays, 0.0), arrival.discount.masked_fill(stays, 1.0))


class Eventual(Arrivals):
    """Arrivals under eventual discounting (Voloshin et al. 2023; paper, Eq. 17 and 18).

    Arriving in acceptance pays 1, and γ discounts there. Elsewhere `gamma_between` does, close to
    1: a discount of 1 would leave waiting for ever as good as arriving.
    """

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        s = self.settings
        self.pays = self.accepting.float()
        self.discounts = self.alive * torch.where(self.accepting, s.gamma, s.gamma_between)

    def reward(self, observation: Tensor, state: Tensor) -> Tensor:
        """1 in acceptance."""
        return self.pays[state]
