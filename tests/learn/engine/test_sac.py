"""Soft actor-critic by hand: Eq. 3, Eq. 5, the density after the tanh, the temperature."""

import math

import pytest
import torch
from torch import Tensor
from torch.distributions import Normal, TanhTransform, TransformedDistribution

from tests.learn.examples import generator, settings
from tiloilc.learn.engine.networks import StackedMLP
from tiloilc.learn.engine.sac import (
    LEAST_ALPHA,
    LOG_STD_MAX,
    LOG_STD_MIN,
    Imitated,
    SoftActorCritic,
)  # fmt: skip

SEEDS, INPUTS, ACTIONS, N = 3, 4, 2, 5


def sac(**changes: object) -> SoftActorCritic:
    given = settings(seeds=SEEDS, tau=0.25, **changes)
    return SoftActorCritic(SEEDS, INPUTS, ACTIONS, given, generator())


def inputs(seed: int = 1) -> Tensor:
    return torch.randn(SEEDS, N, INPUTS, generator=generator(seed))


def actions(seed: int = 2) -> Tensor:
    return 2 * torch.rand(SEEDS, N, ACTIONS, generator=generator(seed)) - 1


def perceptron(nets: StackedMLP, which: int, x: Tensor) -> Tensor:
    """One of the stacked perceptrons, written out."""
    for i, (weight, bias) in enumerate(zip(nets.weights, nets.biases, strict=True)):
        x = x @ weight[which] + bias[which]
        if i < len(nets.weights) - 1:
            if nets.layer_norm:
                mean, variance = x.mean(-1, keepdim=True), x.var(-1, keepdim=True, correction=0)
                x = (x - mean) / (variance + 1e-5).sqrt()
            x = x.clamp(min=0)
    return x


def values(sac: SoftActorCritic, x: Tensor, action: Tensor) -> Tensor:
    """Both critics of every seed, written out: [seed, 2, n]."""
    joint = torch.cat([x, action], -1)
    return torch.stack(
        [
            torch.stack([perceptron(sac.critics, 2 * s + k, joint[s])[:, 0] for k in (0, 1)])
            for s in range(SEEDS)
        ]
    )


@pytest.mark.parametrize("layer_norm", [True, False])
def test_stacked_networks_are_separate_networks(layer_norm: bool) -> None:
    nets = StackedMLP(3, [4, 8, 8, 2], generator(), layer_norm)
    x = torch.randn(3, 6, 4, generator=generator(1))
    for k in range(3):
        assert torch.allclose(nets(x)[k], perceptron(nets, k, x[k]), atol=1e-6)


def test_weights_begin_as_in_torch_linear() -> None:
    nets = StackedMLP(50, [16, 64, 1], generator())
    for weight, bias, fan in zip(nets.weights, nets.biases, (16, 64), strict=True):
        bound = 1 / math.sqrt(fan)
        for tensor in (weight, bias):
            assert tensor.abs().max() <= bound
            assert tensor.std().item() == pytest.approx(bound / math.sqrt(3), rel=0.15)


def test_critics_belong_to_their_seeds() -> None:
    agent = sac()
    x, a = inputs(), actions()
    assert torch.allclose(agent.q(agent.critics, x, a), values(agent, x, a), atol=1e-6)


def test_the_critic_loss_is_half_the_squared_error_of_both_critics() -> None:
    """Eq. 3, with the mean over the batch."""
    agent = sac()
    x, a, target = inputs(), actions(), torch.randn(SEEDS, N, generator=generator(3))
    expected = [
        sum(sum(0.5 * (float(q[k, j]) - float(y[j])) ** 2 for j in range(N)) / N for k in (0, 1))
        for q, y in zip(values(agent, x, a).detach(), target, strict=True)
    ]
    assert agent.update_critics(x, a, target).tolist() == pytest.approx(expected, rel=1e-5)


def test_critics_move_towards_their_targets_and_targets_follow() -> None:
    agent = sac(critic_rate=0.01)
    x, a, target = inputs(), actions(), torch.full((SEEDS, N), 3.0)
    old = [p.clone() for p in agent.targets.parameters]
    first = agent.update_critics(x, a, target)
    assert all(torch.equal(p, q) for p, q in zip(old, agent.targets.parameters, strict=True))
    agent.follow()
    for before, now, online in zip(
        old, agent.targets.parameters, agent.critics.parameters, strict=True
    ):
        assert torch.allclose(now, 0.75 * before + 0.25 * online, atol=1e-7)
    for _ in range(200):
        last = agent.update_critics(x, a, target)
    assert (last < first / 10).all()


def test_the_log_density_is_that_after_the_tanh() -> None:
    agent = sac()
    x = inputs()
    drawn = agent.sample(x)
    out = torch.stack([perceptron(agent.actor, s, x[s]) for s in range(SEEDS)])
    mean, raw = out[..., :ACTIONS], out[..., ACTIONS:]
    log_std = LOG_STD_MIN + (LOG_STD_MAX - LOG_STD_MIN) * (torch.tanh(raw) + 1) / 2
    law = TransformedDistribution(Normal(mean, log_std.exp()), TanhTransform())
    expected = law.log_prob(drawn.action.clamp(-1 + 1e-6, 1 - 1e-6)).sum(-1)
    inside = drawn.action.abs().amax(-1) < 0.999
    assert inside.sum() > 5
    assert torch.allclose(drawn.log_density[inside], expected[inside], atol=1e-2)
    assert (drawn.action.abs() <= 1).all()
    assert torch.allclose(agent.mean_action(x), torch.tanh(mean), atol=1e-6)


def test_the_log_density_is_finite_where_the_tanh_saturates() -> None:
    agent = sac()
    drawn = agent.sample(1e4 * inputs())
    assert torch.isfinite(drawn.log_density).all()
    assert drawn.action.abs().max() == 1


def test_the_soft_value_is_the_lesser_target_critic_minus_the_entropy_term() -> None:
    agent = sac(entropy=0.3)
    x = inputs()
    agent.update_critics(x, actions(), torch.ones(SEEDS, N))  # targets differ from critics now
    state = agent.generator.get_state()
    value = agent.soft_value(x)
    agent.generator.set_state(state)
    drawn = agent.sample(x)
    q = agent.q(agent.targets, x, drawn.action)
    expected = torch.minimum(q[:, 0], q[:, 1]) - 0.3 * drawn.log_density
    assert torch.allclose(value, expected, atol=1e-6)


def test_the_actor_loss_is_the_entropy_term_minus_the_lesser_critic() -> None:
    """Eq. 5, with the mean over the batch."""
    agent = sac(entropy=0.3)
    x = inputs()
    state = agent.generator.get_state()
    drawn = agent.sample(x)
    q = values(agent, x, drawn.action).amin(1)
    expected = (0.3 * drawn.log_density - q).mean(1)
    agent.generator.set_state(state)
    critics = [p.clone() for p in agent.critics.parameters]
    actor = [p.clone() for p in agent.actor.parameters]
    loss = agent.update_actor(x)
    assert torch.allclose(loss, expected, atol=1e-5)
    assert all(torch.equal(p, q) for p, q in zip(critics, agent.critics.parameters, strict=True))
    assert not torch.equal(actor[0], agent.actor.parameters[0])


def test_a_seeds_update_depends_on_its_own_batch_only() -> None:
    one, two = sac(), sac()
    x, other = inputs(), inputs()
    other[1] = 5.0
    for agent, seen in ((one, x), (two, other)):
        agent.update_critics(seen, actions(), torch.ones(SEEDS, N))
        agent.update_actor(seen)
    for p, q in zip(one.actor.parameters, two.actor.parameters, strict=True):
        assert torch.equal(p[0], q[0])
        assert torch.equal(p[2], q[2])
    assert not torch.equal(one.actor.parameters[0][1], two.actor.parameters[0][1])
    for p, q in zip(one.critics.parameters, two.critics.parameters, strict=True):
        assert torch.equal(p[[0, 1, 4, 5]], q[[0, 1, 4, 5]])


def written_out(agent: SoftActorCritic, x: Tensor, noise: Tensor, alpha: float) -> Tensor:
    """Eq. 5 by autograd, for each seed: the actor's parameters take gradients."""
    out = torch.stack([perceptron(agent.actor, s, x[s]) for s in range(SEEDS)])
    log_std = LOG_STD_MIN + (LOG_STD_MAX - LOG_STD_MIN) * (torch.tanh(out[..., ACTIONS:]) + 1) / 2
    law = TransformedDistribution(Normal(out[..., :ACTIONS], log_std.exp()), TanhTransform())
    before = out[..., :ACTIONS] + log_std.exp() * noise
    squash = (1 - torch.tanh(before).square()).log()
    density = (law.base_dist.log_prob(before) - squash).sum(-1)
    return (alpha * density - values(agent, x, torch.tanh(before)).amin(1)).mean(1)


@pytest.mark.parametrize("layer_norm", [True, False])
@pytest.mark.parametrize("weight", [0.0, 7.0])
def test_the_actors_slope_is_that_of_its_loss(layer_norm: bool, weight: float) -> None:
    """Eq. 5 and what is imitated, against autograd in double precision."""
    torch.set_default_dtype(torch.float64)
    try:
        agent = sac(entropy=0.3, layer_norm=layer_norm, actor_hidden=(8, 8), critic_hidden=(8, 8))
        x, noise, action = inputs(), agent.noise(N), actions()[:, :2]
        parameters = [p.clone().requires_grad_() for p in agent.actor.parameters]
        original, agent.actor.parameters = agent.actor.parameters, parameters
        loss = written_out(agent, x, noise, 0.3)
        greedy = torch.tanh(
            torch.stack([perceptron(agent.actor, s, x[s]) for s in range(SEEDS)])[..., :ACTIONS]
        )
        loss = loss + weight * (greedy[:, :2] - action).square().mean((1, 2))
        expected = torch.autograd.grad(loss.sum(), parameters)
        agent.actor.parameters = original
        imitated = Imitated(action, torch.tensor(weight))
        found = agent.update_actor(x, agent.sample(x, noise), imitated)
    finally:
        torch.set_default_dtype(torch.float32)
    assert found.tolist() == pytest.approx(loss.tolist(), rel=1e-10)
    slopes = agent.actor.slopes
    for mine, theirs in zip(slopes, expected, strict=True):
        assert torch.allclose(mine, theirs, rtol=1e-8, atol=1e-10)


def test_what_is_imitated_moves_the_actor() -> None:
    agent = sac(actor_rate=0.01)
    x, half = inputs(), torch.full((SEEDS, N, ACTIONS), 0.5)
    for _ in range(300):
        agent.update_actor(x, imitated=Imitated(half, torch.tensor(1e3)))
    assert (agent.mean_action(x) - 0.5).abs().max() < 0.1


@pytest.mark.parametrize(("wanted", "sign"), [(-30.0, -1), (30.0, 1)])
def test_a_tuned_temperature_follows_the_entropy(wanted: float, sign: int) -> None:
    """More entropy than wanted: it falls; less: it rises."""
    agent = sac(entropy="tuned", target_entropy=wanted)
    assert agent.log_alpha.tolist() == [0.0] * SEEDS
    agent.update_actor(inputs())
    assert (agent.log_alpha.detach() * sign > 0).all()


def test_a_tuned_temperature_comes_back_from_an_entropy_out_of_reach() -> None:
    """It stops at its least, however long there is too much, and rises as soon as there is not."""
    agent = sac(entropy="tuned", target_entropy=-50, critic_rate=1.0)
    for _ in range(16):
        agent.update_actor(inputs())
    assert agent.log_alpha.exp().tolist() == pytest.approx([LEAST_ALPHA] * SEEDS)
    agent = sac(entropy="tuned", target_entropy=50, critic_rate=1.0)
    agent.log_alpha.fill_(math.log(LEAST_ALPHA))
    agent.update_actor(inputs())
    assert (agent.log_alpha.exp() > 2 * LEAST_ALPHA).all()


def test_a_fixed_temperature_stays() -> None:
    agent = sac(entropy=0.2)
    for _ in range(3):
        agent.update_actor(inputs())
    assert agent.log_alpha.exp().tolist() == pytest.approx([0.2] * SEEDS)


def test_sac_goes_on_from_its_state() -> None:
    def step(agent: SoftActorCritic) -> None:
        agent.update_critics(inputs(), actions(), torch.ones(SEEDS, N))
        agent.update_actor(inputs())
        agent.follow()

    first, second = sac(), sac(first_seed=9)
    for _ in range(3):
        step(first)
    second.load({name: tensor.clone() for name, tensor in first.state().items()})
    second.generator.set_state(first.generator.get_state())
    for _ in range(3):
        step(first)
        step(second)
    for name, tensor in first.state().items():
        assert torch.equal(tensor, second.state()[name]), name


def test_forgotten_momentum_is_gone() -> None:
    agent, fresh = sac(), sac()
    agent.update_critics(inputs(), actions(), torch.ones(SEEDS, N))
    agent.update_actor(inputs())
    agent.reset_optimisers()
    for name, tensor in agent.state().items():
        if "adam" in name:
            assert torch.equal(tensor, fresh.state()[name]), name
    both = zip(agent.critics.parameters, fresh.critics.parameters, strict=True)
    assert not any(torch.equal(mine, other) for mine, other in both)
