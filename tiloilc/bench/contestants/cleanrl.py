"""CleanRL's SAC for continuous actions, written out from its published description.

Huang et al. (2022), "CleanRL: high-quality single-file implementations of deep RL algorithms": one
file, a module for each network, both critics under one Adam, a log standard deviation squashed into
[−5, 2], targets followed parameter by parameter, the temperature tuned on fresh actions. Every
second update the actor and the temperature take two steps, so there are as many as the critics'.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.distributions import Normal

from tiloilc.bench.contestants.noise import ACTIONS, OBSERVATIONS, STATES, Noise
from tiloilc.bench.contestants.sb3 import fill
from tiloilc.bench.contestants.work import Run, Work

RATE, CRITIC_RATE, GAMMA, TAU = 3e-4, 1e-3, 0.99, 0.005
ACTOR_EVERY = 2


class Critic(nn.Module):
    """Q(s, a)."""

    def __init__(self, hidden: Sequence[int]) -> None:
        super().__init__()
        self.layers = _layers([OBSERVATIONS + STATES + ACTIONS, *hidden])
        self.last = nn.Linear(hidden[-1], 1)

    def forward(self, x: Tensor, action: Tensor) -> Tensor:
        """Values [n]."""
        h = torch.cat([x, action], 1)
        for layer in self.layers:
            h = torch.relu(layer(h))
        value: Tensor = self.last(h)
        return value.view(-1)


class Actor(nn.Module):
    """A Gaussian squashed by tanh."""

    def __init__(self, hidden: Sequence[int]) -> None:
        super().__init__()
        self.layers = _layers([OBSERVATIONS + STATES, *hidden])
        self.mean, self.spread = nn.Linear(hidden[-1], ACTIONS), nn.Linear(hidden[-1], ACTIONS)

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Actions [n, m] and their log-density [n]."""
        for layer in self.layers:
            x = torch.relu(layer(x))
        log_std = -5 + 0.5 * 7 * (torch.tanh(self.spread(x)) + 1)
        normal = Normal(self.mean(x), log_std.exp())
        drawn = normal.rsample()
        action = torch.tanh(drawn)
        density = normal.log_prob(drawn) - torch.log(1 - action.square() + 1e-6)
        return action, density.sum(1)


def updates(work: Work) -> Run:
    """Updates from Stable-Baselines3's replay, which CleanRL takes, too."""
    from stable_baselines3.common.buffers import ReplayBuffer

    torch.set_num_threads(1)
    torch.manual_seed(0)
    world = Noise(OBSERVATIONS + STATES)
    replay = ReplayBuffer(100_000, world.observation_space, world.action_space, "cpu")
    fill(replay)
    actor, critics = Actor(work.actor), [Critic(work.critic) for _ in range(2)]
    targets = [Critic(work.critic) for _ in range(2)]
    for target, critic in zip(targets, critics, strict=True):
        target.load_state_dict(critic.state_dict())
    weights = [p for critic in critics for p in critic.parameters()]
    critic_adam = torch.optim.Adam(weights, lr=CRITIC_RATE)
    actor_adam = torch.optim.Adam(actor.parameters(), lr=RATE)
    log_alpha = torch.zeros(1, requires_grad=True)
    alpha_adam = torch.optim.Adam([log_alpha], lr=CRITIC_RATE)
    alpha, done = math.exp(0), 0

    def update() -> None:
        nonlocal alpha, done
        batch = replay.sample(work.batch)
        with torch.no_grad():
            action, density = actor(batch.next_observations)
            after = torch.minimum(*(t(batch.next_observations, action) for t in targets))
            live = 1 - batch.dones.flatten()
            wanted = batch.rewards.flatten() + live * GAMMA * (after - alpha * density)
        loss = sum(
            nn.functional.mse_loss(critic(batch.observations, batch.actions), wanted)
            for critic in critics
        )
        assert isinstance(loss, Tensor)
        critic_adam.zero_grad()
        loss.backward()
        critic_adam.step()
        done += 1
        for _ in range(ACTOR_EVERY if done % ACTOR_EVERY == 0 else 0):
            action, density = actor(batch.observations)
            value = torch.minimum(*(critic(batch.observations, action) for critic in critics))
            actor_adam.zero_grad()
            (alpha * density - value).mean().backward()
            actor_adam.step()
            with torch.no_grad():
                _, density = actor(batch.observations)
            alpha_adam.zero_grad()
            (-log_alpha.exp() * (density - ACTIONS)).mean().backward()
            alpha_adam.step()
            alpha = log_alpha.exp().item()
        for target, critic in zip(targets, critics, strict=True):
            for slow, fast in zip(target.parameters(), critic.parameters(), strict=True):
                slow.data.copy_(TAU * fast.data + (1 - TAU) * slow.data)

    def run(times: int) -> None:
        for _ in range(times):
            update()

    return run


def _layers(sizes: Sequence[int]) -> nn.ModuleList:
    return nn.ModuleList(nn.Linear(before, after) for before, after in pairwise(sizes))
