"""Stable-Baselines3's SAC."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from torch import Tensor, nn

from tiloilc.bench.contestants.noise import OBSERVATIONS, STATES, Noise
from tiloilc.bench.contestants.work import WARM_UP, Run, Work
from tiloilc.driver import compile_spec
from tiloilc.spec.settings import Settings


def updates(work: Work) -> Run:
    """Updates from a replay of random steps."""
    model = make_model(work, Noise(OBSERVATIONS + STATES))
    fill(model.replay_buffer)

    return lambda times: model.train(times, work.batch)


def steps(work: Work) -> Run:
    """Environment steps of `learn()`."""
    told = compile_spec(work.path).plan.environment
    world = gymnasium.make(told.id, max_episode_steps=told.horizon, **told.kwargs)
    model = make_model(work, world)
    model.learn(WARM_UP)

    def run(times: int) -> None:
        model.learn(times, reset_num_timesteps=False)

    return run


def make_model(work: Work, world: gymnasium.Env[Any, Any]) -> SAC:
    """The learner with the networks and the batch of `work`."""
    torch.set_num_threads(1)
    model = SAC(
        "MlpPolicy",
        world,
        learning_starts=WARM_UP,
        buffer_size=100_000,
        batch_size=work.batch,
        replay_buffer_class=Judged if work.discriminators else None,
        policy_kwargs={"net_arch": {"pi": [*work.actor], "qf": [*work.critic]}},
        seed=0,
        device="cpu",
    )
    model.set_logger(Logger(None, []))  # its own makes a folder
    return model


def fill(buffer: ReplayBuffer | None) -> None:
    """Random transitions."""
    assert buffer is not None
    rng = np.random.default_rng(0)
    buffer.observations[:] = rng.standard_normal(buffer.observations.shape)
    buffer.next_observations[:] = rng.standard_normal(buffer.observations.shape)
    buffer.actions[:] = rng.uniform(-1, 1, buffer.actions.shape)
    buffer.full = True


class Judged(ReplayBuffer):
    """Replay whose rewards are today's discriminators': one network a stage, as in the paper.

    Each time a batch is drawn, each discriminator takes one step on 64 positive and 64 negative
    states, and pays its stage's states. Written as one would beside Stable-Baselines3: a module and
    an optimiser for each.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        settings = Settings.model_validate({"preset": "paper", "steps": 1})
        self.half = settings.discriminator_batch
        (hidden,) = settings.discriminator_hidden
        self.nets = [
            nn.Sequential(nn.Linear(OBSERVATIONS, hidden), nn.ReLU(), nn.Linear(hidden, 1))
            for _ in range(STATES - 1)
        ]
        self.adams = [
            torch.optim.Adam(net.parameters(), lr=settings.discriminator_rate) for net in self.nets
        ]
        self.wanted = torch.cat([torch.ones(self.half, 1), torch.zeros(self.half, 1)])

    def sample(self, batch_size: int, env: Any = None) -> ReplayBufferSamples:
        """A batch with the rewards of Eq. 8."""
        for net, adam in zip(self.nets, self.adams, strict=True):
            logits = net(torch.cat([self._states(), self._states()]))
            loss = nn.functional.binary_cross_entropy_with_logits(logits, self.wanted)
            adam.zero_grad()
            loss.backward()
            adam.step()
        drawn = super().sample(batch_size, env)
        seen = drawn.observations[:, :OBSERVATIONS]
        stage = drawn.observations[:, OBSERVATIONS:].argmax(1, keepdim=True)
        with torch.no_grad():
            bonus = torch.cat([torch.tanh(net(seen)) for net in self.nets], 1)
        bonus = bonus.gather(1, stage.clamp(max=len(self.nets) - 1))
        return drawn._replace(rewards=(stage + bonus / 3) / len(self.nets))

    def _states(self) -> Tensor:
        rows = np.random.randint(0, len(self.observations), self.half)  # noqa: NPY002  # as theirs
        return torch.from_numpy(self.observations[rows, 0, :OBSERVATIONS])
