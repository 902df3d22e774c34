"""Actions for state-only demonstrations, and a policy cloned from them."""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.networks import StackedMLP, adam
from tiloilc.learn.replay import Layout, Replay
from tiloilc.learn.sac import SoftActorCritic

INVERSE_HIDDEN = (64, 64)
INVERSE_STEPS = 1500
INVERSE_BATCH = 256
INVERSE_RATE = 3e-3
"""Inverse dynamics is a small regression; these settings fit FlatWorld to an error below 0.01."""

CLONING_STEPS = 1000
CLONING_BATCH = 128
CLONING_RATE = 3e-3


def fit_inverse_dynamics(
    replay: Replay, layout: Layout, generator: torch.Generator
) -> InverseModel:
    """Fit (s, s') → a on the agent's own transitions, for each seed on its own."""
    model = InverseModel(replay, layout, generator)
    for _ in range(INVERSE_STEPS):
        batch = layout.unpack(replay.sample(INVERSE_BATCH, generator))
        model.update(batch.observation, batch.next_observation, batch.action)
    return model


class InverseModel:
    """a from (s, s' − s), both standardised on the replay; [seed, n, d] to [seed, n, m]."""

    def __init__(self, replay: Replay, layout: Layout, generator: torch.Generator) -> None:
        seen = layout.unpack(replay.rows[:, : len(replay)])
        change = seen.next_observation - seen.observation
        self.mean = seen.observation.mean(1, keepdim=True)
        self.scale = seen.observation.std(1, keepdim=True).clamp(min=1e-6)
        self.step = change.std(1, keepdim=True).clamp(min=1e-6)
        sizes = [2 * layout.observation, *INVERSE_HIDDEN, layout.action]
        self.net = StackedMLP(replay.rows.shape[0], sizes, generator)
        self.adam = adam(self.net.parameters, INVERSE_RATE)

    def __call__(self, observation: Tensor, after: Tensor) -> Tensor:
        """The action that leads from `observation` to `after`, in [−1, 1]."""
        x = [(observation - self.mean) / self.scale, (after - observation) / self.step]
        return torch.tanh(self.net(torch.cat(x, dim=-1)))

    def update(self, observation: Tensor, after: Tensor, action: Tensor) -> None:
        """One step of least squares."""
        loss = (self(observation, after) - action).square().mean((1, 2)).sum()
        self.adam.zero_grad()
        loss.backward()
        self.adam.step()


def cloning_loss(sac: SoftActorCritic, x: Tensor, action: Tensor) -> Tensor:
    """Squared error of the greedy action, for each seed."""
    return (sac.mean_action(x) - action).square().mean((1, 2))


def clone(sac: SoftActorCritic, x: Tensor, action: Tensor, generator: torch.Generator) -> None:
    """Behaviour cloning of demonstration steps x [seed, n, in] → action [seed, n, m]."""
    optimiser = adam(sac.actor.parameters, CLONING_RATE)
    for _ in range(CLONING_STEPS):
        rows = torch.randint(x.shape[1], (CLONING_BATCH,), generator=generator)
        loss = cloning_loss(sac, x[:, rows], action[:, rows]).sum()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
