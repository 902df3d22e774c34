"""What baselines have in common: a step pays for where it arrives, then comes the rest."""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.algorithm.method import Plain, Setup
from tiloilc.learn.engine.replay import Batch


class Arrivals(Plain):
    """A method whose target is r + Γ · V(s', b') of the best option b'.

    `doomed` says whether the method knows that a sink is worth nothing: then V is 0 there, else it
    is learned as elsewhere.
    """

    doomed = True

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        device = setup.generator.device
        self.accepting = torch.from_numpy(setup.walk.accepting).to(device)
        self.sink = torch.arange(setup.walk.states, device=device) == setup.walk.sink

    def arrive(self, options: Tensor) -> tuple[Tensor, Tensor]:
        """What arriving in each option [seed, n, K] pays, and the discount Γ of what comes then."""
        ones = torch.ones(options.shape, device=options.device)
        return 0 * ones, self.settings.gamma * ones

    def extra(self, batch: Batch, options: Tensor) -> Tensor:
        """What else a step pays, [seed, n, K] or [seed, n, 1]: by where it began, for instance."""
        return torch.zeros((*batch.state.shape, 1), device=options.device)

    def target(self, batch: Batch, options: Tensor, value: Tensor) -> Tensor:
        """r + Γ · V(s', b'), [seed, n]; nothing comes after an environment's own end."""
        if self.walk.costly:  # to jump is a matter of the next step
            value = self.worth(batch.next_observation, options, value).amax(-1, keepdim=True)
            options = options[..., :1]
        reward, discount = self.arrive(options)
        later = self._live(options, value).masked_fill(batch.terminal[..., None], 0.0)
        return (reward + self.extra(batch, options) + discount * later).amax(-1)

    def worth(self, observation: Tensor, options: Tensor, value: Tensor) -> Tensor:
        """The same, as far as it depends on the option."""
        reward, discount = self.arrive(options)
        arrived = reward + discount * self._live(options, value)
        if not self.walk.costly:
            return arrived
        return torch.where(options == options[..., :1], value, arrived)

    def _live(self, options: Tensor, value: Tensor) -> Tensor:
        return value.masked_fill(self.sink[options], 0.0) if self.doomed else value


class Eventual(Arrivals):
    """Arrivals under eventual discounting (Voloshin et al. 2023; paper, Eq. 17 and 18).

    Arriving in acceptance pays 1, and γ discounts there. Elsewhere `gamma_between` does, close to
    1: a discount of 1 would leave waiting for ever as good as arriving.
    """

    def arrive(self, options: Tensor) -> tuple[Tensor, Tensor]:
        """1 in acceptance and 0 elsewhere; γ there and nearly 1 elsewhere."""
        accepting = self.accepting[options]
        s = self.settings
        return accepting.float(), torch.where(accepting, s.gamma, s.gamma_between)

    def reward(self, observation: Tensor, state: Tensor) -> Tensor:
        """1 in acceptance."""
        return self.accepting[state].float()
