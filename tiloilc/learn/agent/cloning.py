"""Actions for state-only demonstrations, and a policy cloned from them."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.agent.shown import Shown
from tiloilc.learn.engine.networks import Adam, StackedMLP, Tape
from tiloilc.learn.engine.replay import Layout, Replay
from tiloilc.learn.engine.sac import SoftActorCritic, imitation
from tiloilc.product import Floats

INVERSE_HIDDEN = (64, 64)
INVERSE_STEPS = 1500
INVERSE_BATCH = 256
INVERSE_RATE = 3e-3
"""Inverse dynamics is a small regression; these settings fit FlatWorld to an error below 0.01."""

SCALED_BY = 200_000
"""Steps, at most, that inputs are standardised on: evenly spaced ones of a fuller replay."""

MOVED = 0.01
"""An input whose spread is a smaller share of how far away demonstrations are says nothing."""

REACH = 5.0
"""Standard deviations beyond which the net is not asked: it was fitted to none out there."""

CLONING_STEPS = 1000
CLONING_BATCH = 128
CLONING_RATE = 3e-3


def demonstrated_rows(
    shown: Shown,
    replay: Replay,
    layout: Layout,
    low: NDArray[Any],
    high: NDArray[Any],
    kept: Floats,
    generator: torch.Generator,
) -> Tensor | None:
    """The steps that are `shown` as rows of a replay, [seed, n, width]; None without steps.

    `kept` [n, columns] is what the algorithm keeps of each. Recorded actions are scaled from
    between `low` and `high`; where there are none they are inferred from the agent's own steps.
    Raises CompileError JOB604 if it took none.
    """
    if len(shown.observation) == 0:
        return None
    seeds, device = replay.rows.shape[0], generator.device
    before = torch.from_numpy(shown.observation).to(device).expand(seeds, -1, -1)
    after = torch.from_numpy(shown.next_observation).to(device).expand(seeds, -1, -1)
    if shown.action is None and len(replay) == 0:
        problem = "actions cannot be inferred before the agent's first steps are in its replay"
        help = "take more random steps: an episode's, where the algorithm judges whole ones"
        raise CompileError(
            Diagnostic.of("JOB604", setting="learning_starts", problem=problem, help=help)
        )
    if shown.action is None:
        action = infer_actions(before, after, replay, layout, generator)
    else:
        scaled = 2 * (shown.action - low) / (high - low) - 1
        action = torch.from_numpy(scaled.astype(np.float32)).to(device).expand(seeds, -1, -1)
    rest = torch.from_numpy(np.stack([shown.state, shown.letter], axis=1)).to(before)
    ended = before.new_zeros(seeds, len(shown.state), 1)
    judged = torch.from_numpy(kept).to(before).expand(seeds, -1, -1)
    return torch.cat([before, action, after, rest.expand(seeds, -1, -1), ended, judged], dim=-1)


def infer_again(rows: Tensor, replay: Replay, layout: Layout, generator: torch.Generator) -> None:
    """Write actions into demonstrated `rows` [seed, n, width], by the agent's steps so far."""
    shown = layout.unpack(rows)
    before, after = shown.observation, shown.next_observation
    shown.action.copy_(infer_actions(before, after, replay, layout, generator))


def infer_actions(
    before: Tensor, after: Tensor, replay: Replay, layout: Layout, generator: torch.Generator
) -> Tensor:
    """The actions [seed, n, m], in [−1, 1], that lead from `before` to `after` [seed, n, d].

    (s, s') → a is fitted to the agent's own transitions, for each seed on its own.
    """
    model = InverseModel(before, after, replay, layout, generator)
    for _ in range(INVERSE_STEPS):
        batch = layout.unpack(replay.sample(INVERSE_BATCH, generator))
        model.update(batch.observation, batch.next_observation, batch.action)
    return model(before, after)


class InverseModel:
    """a from (s, s' − s), both standardised on the replay; [seed, n, d] to [seed, n, m].

    What the agent's steps hardly moved, beside the demonstrations `before` → `after`, is left out:
    how far away a block lies that it never touched would be counted in its jitter.
    """

    def __init__(
        self,
        before: Tensor,
        after: Tensor,
        replay: Replay,
        layout: Layout,
        generator: torch.Generator,
    ) -> None:
        every = -(-len(replay) // SCALED_BY)
        seen = layout.unpack(replay.rows[:, : len(replay) : every])
        own = _inputs(seen.observation, seen.next_observation)
        spread = own.std(1, keepdim=True)
        self.mean = own.mean(1, keepdim=True)
        self.mean[..., layout.observation :] = 0  # changes are counted from none
        apart = (_inputs(before, after) - self.mean).square().mean(1, keepdim=True).sqrt()
        tells = (spread > 1e-6) & (spread > MOVED * apart)
        self.scale = torch.where(tells, spread, torch.inf)
        sizes = [2 * layout.observation, *INVERSE_HIDDEN, layout.action]
        self.net = StackedMLP(replay.rows.shape[0], sizes, generator)
        self.adam = Adam(self.net.parameters, INVERSE_RATE)

    def __call__(self, observation: Tensor, after: Tensor) -> Tensor:
        """The action that leads from `observation` to `after`, in [−1, 1]."""
        return torch.tanh(self._forward(observation, after)[0])

    def _forward(self, observation: Tensor, after: Tensor) -> tuple[Tensor, Tape]:
        x = (_inputs(observation, after) - self.mean) / self.scale
        return self.net.forward(x.clamp(-REACH, REACH))

    def update(self, observation: Tensor, after: Tensor, action: Tensor) -> None:
        """One step of least squares."""
        mean, tape = self._forward(observation, after)
        self.adam.step(self.net.backward(tape, imitation(mean, action)[1]))


def _inputs(before: Tensor, after: Tensor) -> Tensor:
    """(s, s' − s) from (s, s'), [seed, n, 2d]."""
    return torch.cat([before, after - before], dim=-1)


def clone(sac: SoftActorCritic, x: Tensor, action: Tensor, generator: torch.Generator) -> None:
    """Behaviour cloning of demonstration steps x [seed, n, in] → action [seed, n, m]."""
    adam = Adam(sac.actor.parameters, CLONING_RATE)
    seeds = torch.arange(len(x), device=x.device)[:, None]
    for _ in range(CLONING_STEPS):
        shape = (len(x), CLONING_BATCH)
        rows = torch.randint(x.shape[1], shape, generator=generator, device=x.device)
        out, tape = sac.actor.forward(x[seeds, rows])
        mean, raw = out.split(sac.actions, dim=-1)
        slope = imitation(mean, action[seeds, rows])[1]
        to_out = torch.cat([slope, torch.zeros_like(raw)], dim=-1)
        adam.step(sac.actor.backward(tape, to_out))
