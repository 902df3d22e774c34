"""SBX, Stable-Baselines3 on JAX: many gradient steps are one compiled program."""

from __future__ import annotations

from sbx import SAC
from stable_baselines3.common.logger import Logger

from tiloilc.bench.contestants.noise import OBSERVATIONS, STATES, Noise
from tiloilc.bench.contestants.sb3 import fill
from tiloilc.bench.contestants.work import WARM_UP, Run, Work

STEPS = 64
"""Gradient steps in one program; each number of them is compiled anew."""


def updates(work: Work) -> Run:
    """Updates from a replay of random steps."""
    model = SAC(
        "MlpPolicy",
        Noise(OBSERVATIONS + STATES),
        learning_starts=WARM_UP,
        buffer_size=100_000,
        batch_size=work.batch,
        policy_kwargs={"net_arch": {"pi": [*work.actor], "qf": [*work.critic]}},
        seed=0,
        device="cpu",
    )
    fill(model.replay_buffer)
    model.set_logger(Logger(None, []))

    def run(times: int) -> None:
        for _ in range(times // STEPS):
            model.train(STEPS, work.batch)

    return run
