"""Actions for state-only demonstrations, and a policy cloned from them."""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.networks import Adam, StackedMLP, Tape
from tiloilc.learn.replay import Layout, Replay
from tiloilc.learn.sac import SoftActorCritic, imitation

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
        self.adam = Adam(self.net.flat, self.net.gradient, INVERSE_RATE)

    def __call__(self, observation: Tensor, after: Tensor) -> Tensor:
        """The action that leads from `observation` to `after`, in [−1, 1]."""
        return torch.tanh(self._forward(observation, after)[0])

    def _forward(self, observation: Tensor, after: Tensor) -> tuple[Tensor, Tape]:
        x = [(observation - self.mean) / self.scale, (after - observation) / self.step]
        return self.net.forward(torch.cat(x, dim=-1))

    def update(self, observation: Tensor, after: Tensor, action: Tensor) -> None:
        """One step of least squares."""
        mean, tape = self._forward(observation, after)
        self.net.backward(tape, imitation(mean, action)[1])
        self.adam.step()


def clone(sac: SoftActorCritic, x: Tensor, action: Tensor, generator: torch.Generator) -> None:
    """Behaviour cloning of demonstration steps x [seed, n, in] → action [seed, n, m]."""
    adam = Adam(sac.actor.flat, sac.actor.gradient, CLONING_RATE)
    for _ in range(CLONING_STEPS):
        rows = torch.randint(x.shape[1], (CLONING_BATCH,), generator=generator, device=x.device)
        out, tape = sac.actor.forward(x[:, rows])
        mean, raw = out.split(sac.actions, dim=-1)
        slope = imitation(mean, action[:, rows])[1]
        sac.actor.backward(tape, torch.cat([slope, torch.zeros_like(raw)], dim=-1))
        adam.step()
