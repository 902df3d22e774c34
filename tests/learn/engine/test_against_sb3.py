"""Our update beside Stable-Baselines3's own `train()`: copied weights, same batch, float64.

Two things are not the same by design and are given to theirs: log σ is squashed into [−5, 2], not
cut off, and nothing is added inside log(1 − tanh²).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from torch import Tensor, nn

from tests.learn.examples import generator, settings
from tiloilc.bench.contestants.noise import ACTIONS, OBSERVATIONS, Noise
from tiloilc.learn.agent.plain import PlainSac
from tiloilc.learn.engine.networks import StackedMLP
from tiloilc.learn.engine.sac import LOG_STD_MAX, LOG_STD_MIN

SEEDS, BATCH, UPDATES = 2, 16, 4
ACTOR, CRITIC = (24, 16), (32, 24)
CLOSE = {"rtol": 1e-9, "atol": 1e-9}
"""Six digits are promised; what is measured is rounding."""


class Squash(nn.Module):
    """Our log σ from what the last layer says."""

    def forward(self, raw: Tensor) -> Tensor:
        return LOG_STD_MIN + 0.5 * (LOG_STD_MAX - LOG_STD_MIN) * (torch.tanh(raw) + 1)


class Theirs:
    """Stable-Baselines3's learner, fed with batches and noise."""

    def __init__(self, seed: int) -> None:
        arch = {"net_arch": {"pi": [*ACTOR], "qf": [*CRITIC]}}
        self.model = SAC("MlpPolicy", Noise(), seed=seed, policy_kwargs=arch, device="cpu")
        self.model.policy.double()
        assert self.model.log_ent_coef is not None
        self.model.log_ent_coef.data = self.model.log_ent_coef.data.double()
        actor: Any = self.model.actor
        self.last = actor.mu, actor.log_std
        actor.log_std = nn.Sequential(actor.log_std, Squash())
        actor.action_dist.epsilon = 0.0
        for net in (actor, self.model.critic, self.model.critic_target):
            net.extract_features = lambda seen, extractor: seen  # would make float32 of it
        self.model.set_logger(Logger(None, []))

    def layers(self, net: Any) -> list[tuple[Tensor, Tensor]]:
        """Weights [in, out] and biases [1, out] of a chain of linear layers."""
        linear = [layer for layer in net if isinstance(layer, nn.Linear)]
        return [(layer.weight.data.T, layer.bias.data[None]) for layer in linear]

    def actor(self) -> list[tuple[Tensor, Tensor]]:
        hidden, last = self.layers(self.model.actor.latent_pi), self.layers(self.last)
        return [*hidden, tuple(torch.cat(pair, dim=1) for pair in zip(*last, strict=True))]  # type: ignore[list-item]

    def critics(self, critics: Any) -> list[list[tuple[Tensor, Tensor]]]:
        return [self.layers(net) for net in critics.q_networks]

    def train(self, batch: ReplayBufferSamples, noise: list[Tensor]) -> dict[str, float]:
        """One update of theirs; the losses that it logs."""
        drawn = iter(noise)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(self.model.replay_buffer, "sample", lambda *a, **k: batch)
            name = "torch.distributions.normal._standard_normal"
            patch.setattr(name, lambda shape, dtype, device: next(drawn))
            self.model.train(1, BATCH)
        names = {"critic": "critic_loss", "actor": "actor_loss", "alpha": "ent_coef_loss"}
        logged = self.model.logger.name_to_value
        return {ours: float(logged[f"train/{theirs}"]) for ours, theirs in names.items()}


@pytest.fixture(autouse=True)
def in_float64() -> Iterator[None]:
    before = torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)
    yield
    torch.set_default_dtype(before)


@pytest.fixture
def theirs() -> list[Theirs]:
    return [Theirs(seed) for seed in range(SEEDS)]


@pytest.fixture
def ours(theirs: list[Theirs]) -> PlainSac:
    agent = PlainSac(
        OBSERVATIONS,
        ACTIONS,
        settings(
            seeds=SEEDS,
            actor_hidden=ACTOR,
            critic_hidden=CRITIC,
            tau=theirs[0].model.tau,
            gamma=theirs[0].model.gamma,
            actor_rate=3e-4,
            critic_rate=3e-4,
            layer_norm=False,
            entropy="tuned",
            target_entropy=-1.0,
        ),
    )
    for seed, other in enumerate(theirs):
        put(agent.sac.actor, seed, other.actor())
        for twin in range(2):
            put(agent.sac.critics, 2 * seed + twin, other.critics(other.model.critic)[twin])
            put(agent.sac.targets, 2 * seed + twin, other.critics(other.model.critic_target)[twin])
    return agent


def put(nets: StackedMLP, which: int, layers: list[tuple[Tensor, Tensor]]) -> None:
    for i, (weight, bias) in enumerate(layers):
        nets.weights[i][which] = weight
        nets.biases[i][which] = bias


def differ(nets: StackedMLP, which: int, layers: list[tuple[Tensor, Tensor]]) -> float:
    """The greatest difference between one of the stacked networks and their layers."""
    pairs = zip(nets.weights, nets.biases, layers, strict=True)
    return max(
        float((own[which] - other).abs().max())
        for weight, bias, layer in pairs
        for own, other in zip((weight, bias), layer, strict=True)
    )


def random(*shape: int, seed: int) -> Tensor:
    return torch.randn(SEEDS, *shape, generator=generator(seed))


def test_log_probabilities_are_theirs(ours: PlainSac, theirs: list[Theirs]) -> None:
    x, noise = random(BATCH, OBSERVATIONS, seed=1), random(BATCH, ACTIONS, seed=2)
    drawn = ours.sac.sample(x, noise)
    for seed, other in enumerate(theirs):
        with pytest.MonkeyPatch.context() as patch:
            name = "torch.distributions.normal._standard_normal"
            patch.setattr(name, lambda shape, dtype, device, seed=seed: noise[seed])
            action, density = other.model.actor.action_log_prob(x[seed])
        torch.testing.assert_close(drawn.action[seed], action, **CLOSE)
        torch.testing.assert_close(drawn.log_density[seed], density, **CLOSE)
        greedy = other.model.actor(x[seed], deterministic=True)
        torch.testing.assert_close(ours.sac.mean_action(x)[seed], greedy, **CLOSE)


def test_losses_and_weights_are_theirs_update_after_update(
    ours: PlainSac, theirs: list[Theirs], monkeypatch: pytest.MonkeyPatch
) -> None:
    for step in range(UPDATES):
        x, after = (random(BATCH, OBSERVATIONS, seed=10 * step + k) for k in (1, 2))
        action = torch.tanh(random(BATCH, ACTIONS, seed=10 * step + 3))
        reward, terminal = random(BATCH, 1, seed=10 * step + 4), torch.zeros(SEEDS, BATCH, 1)
        terminal[:, ::5] = 1
        now, then = (random(BATCH, ACTIONS, seed=10 * step + k) for k in (5, 6))

        rows = torch.cat([x, action, reward, after, terminal], dim=-1)
        drawn = iter([then, now])
        with monkeypatch.context() as patch:
            patch.setattr(ours.replay, "sample", lambda count, generator, rows=rows: rows)
            patch.setattr(ours.sac, "noise", lambda count, drawn=drawn: next(drawn))
            gap = (ours.sac.sample(x, now).log_density - ACTIONS).mean(1)
            alpha_loss = -ours.sac.log_alpha * gap
            losses = {**ours.learn(), "alpha": alpha_loss}

        for seed, other in enumerate(theirs):
            batch = ReplayBufferSamples(
                x[seed], action[seed], after[seed], terminal[seed], reward[seed]
            )
            logged = other.train(batch, [now[seed], then[seed]])
            found = {name: float(loss[seed]) for name, loss in losses.items()}
            assert found == pytest.approx(logged, rel=1e-9, abs=1e-9)
            assert differ(ours.sac.actor, seed, other.actor()) < 1e-9
            for twin in range(2):
                which, model = 2 * seed + twin, other.model
                for nets, critics in (
                    (ours.sac.critics, model.critic),
                    (ours.sac.targets, model.critic_target),
                ):
                    assert differ(nets, which, other.critics(critics)[twin]) < 1e-9
            assert model.log_ent_coef is not None
            alpha = model.log_ent_coef.item()
            assert float(ours.sac.log_alpha[seed]) == pytest.approx(alpha, rel=1e-9)
    assert min(abs(float(loss)) for loss in losses["alpha"]) > 1e-5
