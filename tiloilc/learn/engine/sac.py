"""Soft actor-critic with a leading seed axis; what the targets are is its caller's business."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import softplus

from tiloilc.learn.engine.networks import Adam, StackedMLP, Tape
from tiloilc.learn.engine.state import State
from tiloilc.spec.settings import Settings

LOG_STD_MIN, LOG_STD_MAX = -5.0, 2.0
"""The range of the policy's log standard deviation, as in the usual implementations."""

HALF_RANGE = 0.5 * (LOG_STD_MAX - LOG_STD_MIN)

LEAST_ALPHA = 1e-6
"""A tuned temperature falls no further: an entropy out of reach would take it down without end,
and it would take as long to come back when entropy is wanted again."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Actions in (−1, 1) [seed, n, m] and their log-density [seed, n].

    For the way back: the mean and what was added to it before the tanh, tanh of what log σ comes
    from, all [seed, n, m], and the actor's tape.
    """

    action: Tensor
    log_density: Tensor
    mean: Tensor
    added: Tensor
    squashed: Tensor
    tape: Tape

    def rows(self, rows: slice) -> Sample:
        """Some of the n rows."""
        return Sample(
            self.action[:, rows],
            self.log_density[:, rows],
            self.mean[:, rows],
            self.added[:, rows],
            self.squashed[:, rows],
            self.tape.rows(rows),
        )


@dataclass(frozen=True, slots=True)
class Imitated:
    """Demonstrated actions [seed, n, m] for the first n rows of a batch, and what they weigh."""

    action: Tensor
    weight: Tensor


class SoftActorCritic:
    """Stacked actors and twin critics over inputs x [seed, n, in] and actions [seed, n, m]."""

    def __init__(
        self, seeds: int, inputs: int, actions: int, settings: Settings, generator: torch.Generator
    ) -> None:
        self.seeds, self.actions, self.settings = seeds, actions, settings
        self.generator = generator
        s = settings
        self.actor = StackedMLP(seeds, [inputs, *s.actor_hidden, 2 * actions], generator)
        sizes = [inputs + actions, *s.critic_hidden, 1]
        self.critics = StackedMLP(2 * seeds, sizes, generator, layer_norm=s.layer_norm)
        self.targets = self.critics.clone()
        self.tuned = s.entropy == "tuned"
        start = 0.0 if self.tuned else math.log(max(float(s.entropy), 1e-8))
        self.log_alpha = torch.full((seeds,), start, device=generator.device)
        self.actor_adam = Adam(self.actor.parameters, s.actor_rate)
        self.critic_adam = Adam(self.critics.parameters, s.critic_rate)
        self.alpha_adam = Adam([self.log_alpha], s.critic_rate)

    @property
    def networks(self) -> list[tuple[int, ...]]:
        """The height of each stack and its layers' widths."""
        return [(nets.stack, *nets.sizes) for nets in (self.actor, self.critics)]

    def act(self, x: NDArray[np.float32], noise: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Actions for x [seed, n, in] in numpy: greedy ones, or with `noise` [seed, n, m]."""
        out = self.actor.on_host(x)
        mean, raw = out[..., : self.actions], out[..., self.actions :]
        if noise is not None:
            log_std = LOG_STD_MIN + HALF_RANGE * (np.tanh(raw) + 1)
            mean = np.add(mean, np.exp(log_std) * noise, dtype=mean.dtype)
        return np.tanh(mean)

    def reset_optimisers(self) -> None:
        """Forget all momentum: for the moment when a loss changes its meaning."""
        for adam in (self.actor_adam, self.critic_adam, self.alpha_adam):
            adam.reset()

    def slow(self, share: float) -> None:
        """Let actor and critics step by `share` of their first step sizes."""
        for adam in (self.actor_adam, self.critic_adam):
            adam.slow(share)

    def mean_action(self, x: Tensor) -> Tensor:
        """The greedy action, [seed, n, m]."""
        return torch.tanh(self.actor(x)[..., : self.actions])

    def noise(self, count: int) -> Tensor:
        """What `sample` needs for `count` rows of each seed: [seed, count, m]."""
        shape = (self.seeds, count, self.actions)
        return torch.randn(shape, generator=self.generator, device=self.generator.device)

    def sample(self, x: Tensor, noise: Tensor | None = None) -> Sample:
        """An action of the stochastic policy with its log-density after the tanh."""
        if noise is None:
            noise = self.noise(x.shape[1])
        out, tape = self.actor.forward(x)
        mean, raw = out.split(self.actions, dim=-1)
        squashed = torch.tanh(raw)
        log_std = LOG_STD_MIN + HALF_RANGE * (squashed + 1)
        added = log_std.exp() * noise
        before = mean + added
        gaussian = -0.5 * noise.square() - log_std - 0.5 * math.log(2 * math.pi)
        # log(1 - tanh²(u)) = 2 (log 2 - u - softplus(-2u)), stable for large |u|
        squash = 2 * (math.log(2) - before - softplus(-2 * before))
        density = (gaussian - squash).sum(-1)
        return Sample(torch.tanh(before), density, mean, added, squashed, tape)

    def q(self, critics: StackedMLP, x: Tensor, action: Tensor) -> Tensor:
        """Both critics' values, [seed, 2, n]."""
        return self._q(critics, x, action)[0]

    def _q(self, critics: StackedMLP, x: Tensor, action: Tensor) -> tuple[Tensor, Tape]:
        joint = torch.cat([x, action], dim=-1)
        value, tape = critics.forward(joint.repeat_interleave(2, dim=0))
        return value.view(self.seeds, 2, -1), tape

    def soft_value(self, x: Tensor, drawn: Sample | None = None) -> Tensor:
        """V(x) = min Q_target(x, a) − α log π(a | x) for one sampled a; [seed, n]."""
        drawn = self.sample(x) if drawn is None else drawn
        alpha = self.log_alpha.exp()[:, None]
        return self.q(self.targets, x, drawn.action).amin(1) - alpha * drawn.log_density

    def greedy_value(self, x: Tensor) -> Tensor:
        """min Q(x, a) for the greedy a; [seed, n]."""
        return self.q(self.critics, x, self.mean_action(x)).amin(1)

    def update_critics(self, x: Tensor, action: Tensor, target: Tensor) -> Tensor:
        """One step on Eq. 3 towards `target` [seed, n]; the loss of each seed."""
        value, tape = self._q(self.critics, x, action)
        error = value - target[:, None]
        to_value = (error / error.shape[2]).view(2 * self.seeds, -1, 1)
        self.critic_adam.step(self.critics.backward(tape, to_value))
        return 0.5 * error.square().mean(2).sum(1)

    def update_actor(
        self, x: Tensor, drawn: Sample | None = None, imitated: Imitated | None = None
    ) -> Tensor:
        """One step on Eq. 5, plus the loss of imitating what is `imitated`; then the temperature's.

        The slopes of Eq. 5, with u what goes into the tanh, a = tanh u and log π = Σ log π(aᵢ):
        ∂ log π / ∂u = 2a, ∂a / ∂u = 1 − a², ∂u / ∂ log σ = u − mean, and log σ lowers log π by 1.
        """
        drawn = self.sample(x) if drawn is None else drawn
        n, m = x.shape[1], self.actions
        alpha = self.log_alpha.exp()[:, None]
        value, tape = self._q(self.critics, x, drawn.action)
        least, which = value.min(1)
        loss = (alpha * drawn.log_density - least).mean(1)
        to_value = torch.stack([which - 1.0, 0.0 - which], dim=1).view(-1, n, 1) / n
        to_action = self.critics.input_slope(tape, to_value, m).view(-1, 2, n, m).sum(1)
        action, entropy = drawn.action, alpha[..., None] / n
        to_mean = 2 * entropy * action + to_action * (1 - action.square())
        to_log_std = to_mean * drawn.added - entropy
        to_raw = to_log_std * HALF_RANGE * (1 - drawn.squashed.square())
        if imitated is not None:
            rows = imitated.action.shape[1]
            distance, slope = imitation(drawn.mean[:, :rows], imitated.action)
            to_mean[:, :rows] += imitated.weight * slope
            loss = loss + imitated.weight * distance
        to_out = torch.cat([to_mean, to_raw], dim=-1)
        self.actor_adam.step(self.actor.backward(drawn.tape, to_out))
        if self.tuned:
            wanted = self.settings.target_entropy * m
            self.alpha_adam.step([(-wanted - drawn.log_density).mean(1)])
            self.log_alpha.clamp_(min=math.log(LEAST_ALPHA))
        return loss

    def follow(self) -> None:
        """Move the target critics."""
        self.targets.follow(self.critics, self.settings.tau)

    def policy(self) -> State:
        """What acting needs."""
        actor, critics = self.actor.state("actor"), self.critics.state("critics")
        return {**actor, **critics, "log_alpha": self.log_alpha}

    def state(self) -> State:
        """Everything, for a checkpoint."""
        return {
            **self.policy(),
            **self.targets.state("targets"),
            **self.actor_adam.state("actor_adam"),
            **self.critic_adam.state("critic_adam"),
            **self.alpha_adam.state("alpha_adam"),
        }

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.actor.load(state, "actor")
        self.critics.load(state, "critics")
        self.log_alpha.copy_(state["log_alpha"])

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.load_policy(state)
        self.targets.load(state, "targets")
        self.actor_adam.load(state, "actor_adam")
        self.critic_adam.load(state, "critic_adam")
        self.alpha_adam.load(state, "alpha_adam")


def imitation(mean: Tensor, action: Tensor) -> tuple[Tensor, Tensor]:
    """Squared error [seed] of the greedy action, and its slope at the `mean` [seed, n, m]."""
    greedy = torch.tanh(mean)
    error = greedy - action
    slope = error * (1 - greedy.square()) * (2 / (error.shape[1] * error.shape[2]))
    return error.square().mean((1, 2)), slope
