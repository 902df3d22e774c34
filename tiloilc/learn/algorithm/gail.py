"""GAIL from states (Ho and Ermon, NeurIPS 2016; Torabi, Warnell and Stone 2018), off-policy on SAC.

Faithful: one discriminator f between states of demonstrations and of the agent, the agent paid by
it. Reconstructed, as the paper's appendix leaves it open: the agent's states are all that it has
seen, not the latest policy's; the reward is tanh f(s), TiLoIL's bounded form, of today's f. The
formula plays no part but that the policy is told the automaton's state.
"""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.algorithm.arrivals import Arrivals
from tiloilc.learn.algorithm.discriminator import make_discriminators, shown_and_own
from tiloilc.learn.algorithm.method import Setup
from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.product import Floats, Int


class GAIL(Arrivals):
    """Being in s pays tanh f(s)."""

    doomed = False

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        shown = setup.demonstrations
        unions = shown_and_own(setup.walk.states)
        self.discriminator = make_discriminators(setup, unions, shown[:0])
        for seed in range(self.settings.seeds):
            self.discriminator.add(seed, 0, shown.cpu().numpy())

    def see(self, after: Floats, state: Int, arrived: Int) -> None:
        """Keep the agent's states."""
        self.discriminator.see(after)
        for seed, states in enumerate(after):
            self.discriminator.add(seed, 1, states)

    def draw(self) -> State:
        """Which states are compared."""
        return self.discriminator.draw()

    def learn(self, chance: State) -> dict[str, Tensor]:
        """A step of the discriminator."""
        return self.discriminator.learn(chance)

    def extra(self, batch: Batch, options: Tensor) -> Tensor:
        """tanh f(s)."""
        return self.reward(batch.observation, batch.state)[..., None]

    def reward(self, observation: Tensor, state: Tensor) -> Tensor:
        """tanh f(s), whatever b is."""
        return self.discriminator.bonus(observation, torch.zeros_like(state))

    def rings(self) -> dict[str, Ring]:
        """Both sides' states."""
        return self.discriminator.rings()

    def state(self) -> State:
        """The discriminator, and how full its buffers are."""
        return with_prefix("discriminator", self.discriminator.state())

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.discriminator.load(under("discriminator", state))
