"""Small tasks for the tests of learning: plans, labels and policies that do as they are told."""

import shutil
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch

from tests.product import worlds  # noqa: F401  # registers
from tiloilc.automaton.ldba import Ldba
from tiloilc.demos import Demo, DemoSet
from tiloilc.learn.agent.shown import Shown
from tiloilc.learn.engine.replay import Batch
from tiloilc.plan import Plan, stage_plan
from tiloilc.product import Floats, Int
from tiloilc.spec.model import Demonstrations, Environment, Evaluate
from tiloilc.spec.settings import Settings

COMPILER = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
"""What compiles updates here, None where nothing does."""

SMALL: Mapping[str, object] = {
    "steps": 200,
    "seeds": 2,
    "checkpoint_every": 25,
    "learning_starts": 60,
    "batch_size": 16,
    "actor_hidden": (16,),
    "critic_hidden": (16,),
    "discriminator_hidden": (8,),
    "discriminator_batch": 16,
}
"""Settings that train in a second."""


def settings(**changes: object) -> Settings:
    return Settings.model_validate({**SMALL, **changes})


def plan(
    ldba: Ldba,
    environment: str,
    horizon: int = 10,
    actions: str = "inferred",
    kwargs: Mapping[str, Any] | None = None,
    every: int | None = 40,
    **changes: object,
) -> Plan:
    """A plan by hand; its labels are the caller's."""
    return Plan(
        name="task",
        description="",
        environment=Environment(id=environment, horizon=horizon, kwargs=dict(kwargs or {})),
        fields={},
        predicates=(),
        formula="",
        ldba=ldba,
        stages=stage_plan(ldba),
        demonstrations=Demonstrations.model_validate({"count": 5, "actions": actions}),
        train=settings(**changes),
        evaluate=Evaluate(episodes=3, every=every),
        digests={},
        version="0",
    )


def cell_is(*cells: int) -> Any:
    """Labels of one-dimensional cells: proposition i holds in `cells[i]`."""

    def labels(observations: Floats) -> Int:
        at = observations[:, :1].astype(np.int64) == np.array(cells)
        letters: Int = (at << np.arange(len(cells))).sum(1)
        return letters

    return labels


def beyond(*bounds: float) -> Any:
    """Labels of continuous states: proposition i holds where |x₀| is above `bounds[i]`."""

    def labels(observations: Floats) -> Int:
        at = np.abs(observations[:, :1]) > np.array(bounds)
        letters: Int = (at << np.arange(len(bounds))).sum(1)
        return letters

    return labels


def demos(*paths: list[float] | list[list[float]]) -> DemoSet:
    """Demonstrations of states only."""
    return DemoSet(
        tuple(Demo(np.array(path, dtype=np.float32).reshape(len(path), -1)) for path in paths)
    )


def nothing_shown(d: int) -> Shown:
    """No demonstrations."""
    return Shown.states_only(np.zeros((0, d), np.float32))


def steps(state: torch.Tensor, terminal: torch.Tensor) -> Batch:
    """Steps from automaton states [seed, n] of which nothing else matters."""
    seen = torch.zeros(*state.shape, 1)
    no = torch.zeros_like(terminal)
    return Batch(seen, seen, seen, state, torch.zeros_like(state), terminal, seen[..., :0], no)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)
