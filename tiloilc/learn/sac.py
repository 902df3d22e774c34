"""Soft actor-critic with a leading seed axis; what the targets are is its caller's business."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from tiloilc.learn.networks import StackedMLP, adam
from tiloilc.learn.state import adam_state, load_adam
from tiloilc.spec.settings import Settings

LOG_STD_MIN, LOG_STD_MAX = -5.0, 2.0
"""The range of the policy's log standard deviation, as in the usual implementations."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Actions in (−1, 1) [seed, n, m] and their log-density [seed, n]."""

    action: Tensor
    log_density: Tensor


class SoftActorCritic:
    """Stacked actors and twin critics over inputs x [seed, n, in] and actions [seed, n, m]."""

    def __init__(
        self, seeds: int, inputs: int, actions: int, settings: Settings, generator: torch.Generator
    ) -> None:
        self.seeds, self.actions, self.settings, self.generator = (
            seeds,
            actions,
            settings,
            generator,
        )
        self.actor = StackedMLP(seeds, [inputs, *settings.actor_hidden, 2 * actions], generator)
        self.critics = StackedMLP(
            2 * seeds,
            [inputs + actions, *settings.critic_hidden, 1],
            generator,
            layer_norm=settings.layer_norm,
        )
        self.targets = self.critics.clone()
        tuned = settings.entropy == "tuned"
        start = 1.0 if tuned else max(float(settings.entropy), 1e-8)
        self.log_alpha = torch.full((seeds,), math.log(start), requires_grad=tuned)
        self.reset_optimisers()

    def reset_optimisers(self) -> None:
        """Forget all momentum: for the moment when a loss changes its meaning."""
        s = self.settings
        self.actor_adam = adam(self.actor.parameters, s.actor_rate)
        self.critic_adam = adam(self.critics.parameters, s.critic_rate)
        self.alpha_adam = adam([self.log_alpha], s.critic_rate)

    def mean_action(self, x: Tensor) -> Tensor:
        """The greedy action, [seed, n, m]."""
        return torch.tanh(self.actor(x)[..., : self.actions])

    def sample(self, x: Tensor) -> Sample:
        """An action of the stochastic policy with its log-density after the tanh."""
        mean, raw = self.actor(x).split(self.actions, dim=-1)
        log_std = LOG_STD_MIN + 0.5 * (LOG_STD_MAX - LOG_STD_MIN) * (torch.tanh(raw) + 1)
        noise = torch.randn(mean.shape, generator=self.generator)
        before = mean + log_std.exp() * noise
        gaussian = -0.5 * noise.square() - log_std - 0.5 * math.log(2 * math.pi)
        # log(1 - tanh²(u)) = 2 (log 2 - u - softplus(-2u)), stable for large |u|
        squash = 2 * (math.log(2) - before - torch.nn.functional.softplus(-2 * before))
        return Sample(torch.tanh(before), (gaussian - squash).sum(-1))

    def q(self, critics: StackedMLP, x: Tensor, action: Tensor) -> Tensor:
        """Both critics' values, [seed, 2, n]."""
        joint = torch.cat([x, action], dim=-1)
        return critics(joint.repeat_interleave(2, dim=0)).view(self.seeds, 2, -1)

    @torch.no_grad()
    def soft_value(self, x: Tensor) -> Tensor:
        """V(x) = min Q_target(x, a) − α log π(a | x) for one sampled a; [seed, n]."""
        drawn = self.sample(x)
        alpha = self.log_alpha.exp()[:, None]
        return self.q(self.targets, x, drawn.action).amin(1) - alpha * drawn.log_density

    def update_critics(self, x: Tensor, action: Tensor, target: Tensor) -> Tensor:
        """One step on Eq. 3 towards `target` [seed, n]; the loss of each seed."""
        error = self.q(self.critics, x, action) - target[:, None]
        loss = 0.5 * error.square().mean(2).sum(1)
        self.critic_adam.zero_grad()
        loss.sum().backward()
        self.critic_adam.step()
        return loss.detach()

    def update_actor(self, x: Tensor, extra: Tensor | None = None) -> Tensor:
        """One step on Eq. 5, plus an `extra` loss [seed], then the temperature's."""
        alpha = self.log_alpha.detach().exp()[:, None]
        drawn = self.sample(x)
        value = self.q(self.critics, x, drawn.action).amin(1)
        loss = (alpha * drawn.log_density - value).mean(1)
        if extra is not None:
            loss = loss + extra
        self.actor_adam.zero_grad()
        loss.sum().backward(inputs=self.actor.parameters)
        self.actor_adam.step()
        if self.log_alpha.requires_grad:
            wanted = self.settings.target_entropy * self.actions
            gap = (drawn.log_density.detach() + wanted).mean(1)
            self.alpha_adam.zero_grad()
            (-self.log_alpha * gap).sum().backward()
            self.alpha_adam.step()
        return loss.detach()

    def follow(self) -> None:
        """Move the target critics."""
        self.targets.follow(self.critics, self.settings.tau)

    def policy(self) -> dict[str, Tensor]:
        """What acting needs."""
        actor, critics = self.actor.state("actor"), self.critics.state("critics")
        return {**actor, **critics, "log_alpha": self.log_alpha.detach()}

    def state(self) -> dict[str, Tensor]:
        """Everything, for a checkpoint."""
        return {
            **self.policy(),
            **self.targets.state("targets"),
            **adam_state(self.actor_adam, "actor_adam"),
            **adam_state(self.critic_adam, "critic_adam"),
            **adam_state(self.alpha_adam, "alpha_adam"),
        }

    def load_policy(self, state: dict[str, Tensor]) -> None:
        """Take what `policy` gave."""
        self.actor.load(state, "actor")
        self.critics.load(state, "critics")
        with torch.no_grad():
            self.log_alpha.copy_(state["log_alpha"])

    def load(self, state: dict[str, Tensor]) -> None:
        """Take what `state` gave."""
        self.load_policy(state)
        self.targets.load(state, "targets")
        load_adam(self.actor_adam, state, "actor_adam")
        load_adam(self.critic_adam, state, "critic_adam")
        load_adam(self.alpha_adam, state, "alpha_adam")
