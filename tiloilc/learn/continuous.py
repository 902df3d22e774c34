"""The agent on continuous tasks: SAC on the product with TiLoIL's rewards and targets."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.cloning import clone, fit_inverse_dynamics
from tiloilc.learn.discriminators import Discriminators, StageBuffers
from tiloilc.learn.replay import Batch, Layout, Replay
from tiloilc.learn.ring import Ring
from tiloilc.learn.sac import Imitated, SoftActorCritic
from tiloilc.learn.shown import Shown
from tiloilc.learn.state import State, under, with_prefix
from tiloilc.learn.tiloil import StageTable, option_values, stage_reward, tiloil_target
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import Settings

if TYPE_CHECKING:
    from gymnasium.spaces import Box, Space


RELABELLED = 0.5
"""How many steps of a batch are read from an automaton state drawn at random, with `relabel`."""


class SacAgent:
    """Everything that learns, for all seeds at once. Arrays are [seed, copy, …]."""

    def __init__(
        self,
        settings: Settings,
        stages: Stages,
        walk: Walk,
        observation_space: Space[Any],
        action_space: Box,
        shown: Shown,
        generator: torch.Generator,
    ) -> None:
        self.settings, self.walk, self.shown, self.generator = settings, walk, shown, generator
        d, m = shown.observation.shape[1], int(np.prod(action_space.shape))
        self.low, self.high = action_space.low.reshape(-1), action_space.high.reshape(-1)
        self.action_shape = action_space.shape
        self.table = StageTable.of(stages, walk, settings)
        self.middle, self.half = _scale(observation_space, shown)
        self.layout = Layout(d, m)
        self.options = torch.from_numpy(walk.options)
        live = [b for b in range(walk.states) if b != walk.sink]
        self.live = self.table.code[live].unique()
        capacity = min(settings.buffer_size, settings.steps)
        self.replay = Replay(settings.seeds, capacity, self.layout.width)
        self.buffers = StageBuffers(
            settings.seeds, stages.sink_buffer + 1, min(settings.stage_buffer_size, capacity), d
        )
        self.discriminators = Discriminators(
            stages, self.buffers, torch.from_numpy(shown.positive), settings, generator
        )
        wanted = settings.beta > 0 or not settings.stages
        self.judges = wanted and self.discriminators.stages > 0
        self.sac = SoftActorCritic(settings.seeds, d + walk.states, m, settings, generator)
        self.demo_rows: Tensor | None = None

    def encode(self, observation: Tensor, state: Tensor) -> Tensor:
        """The networks' input: s scaled and b as one-hot; [seed, n, d + states]."""
        told = torch.nn.functional.one_hot(self.table.code[state], self.walk.states)
        return torch.cat([(observation - self.middle) / self.half, told.float()], dim=-1)

    def act(self, observations: Floats, states: Int, greedy: bool) -> Floats:
        """Actions in the environment's units, [seed, copy, …]."""
        x = self.encode(torch.from_numpy(observations), torch.from_numpy(states))
        action = self.sac.mean_action(x) if greedy else self.sac.sample(x).action
        return self._to_environment(action.numpy())

    def explore(self, rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
        """Uniformly random actions, [seed, copy, …]."""
        drawn = rng.uniform(-1, 1, (*shape, len(self.low))).astype(np.float32)
        return self._to_environment(drawn)

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        """The option of greatest value (drawn by softmax of value / α while exploring)."""
        offered = torch.from_numpy(options)
        seen = torch.from_numpy(observations)
        value = self._option_values(seen, offered, greedy)
        value = option_values(self.table, offered, value, self.settings, self._wait(seen, offered))
        if not greedy:
            noise = torch.rand(value.shape, generator=self.generator).clamp(1e-9, 1 - 1e-9)
            alpha = self.sac.log_alpha.exp()[:, None, None]
            filled = offered == offered[..., :1]  # rows are filled up with their first option
            filled[..., 0] = False
            value = (value - alpha * (-noise.log()).log()).masked_fill(filled, -torch.inf)
        return offered.gather(-1, value.argmax(-1, keepdim=True)).squeeze(-1).numpy()

    def _option_values(self, observation: Tensor, options: Tensor, greedy: bool) -> Tensor:
        seeds, n, k = options.shape
        repeated = observation.repeat_interleave(k, dim=1)
        x = self.encode(repeated, options.reshape(seeds, -1))
        if greedy:
            value = self.sac.q(self.sac.critics, x, self.sac.mean_action(x)).amin(1)
        else:
            value = self.sac.soft_value(x)
        return value.view(seeds, n, k)

    def record(
        self,
        observation: Floats,
        action: Floats,
        after: Floats,
        state: Int,
        letter: Int,
        terminal: NDArray[np.bool_],
    ) -> None:
        """Store one transition of each copy; all [seed, copy, …]."""
        flat = action.reshape(*state.shape, -1)
        scaled = 2 * (flat - self.low) / (self.high - self.low) - 1
        self.replay.add(self.layout.pack(observation, scaled, after, state, letter, terminal))
        self.discriminators.norm.update(torch.from_numpy(after))

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Store a finished segment in its stage buffer."""
        self.buffers.add(seed, buffer, observations)

    def finish(self, over: NDArray[np.bool_], length: Int) -> None:
        """Episodes have ended: transitions are all that matters here."""

    def begin(self) -> bool:
        """The random steps are over: give the demonstrations actions and clone them."""
        self.demo_rows = self._demonstration_rows()
        if self.demo_rows is None or self.settings.warm_start == "none":
            return False
        batch = self.layout.unpack(self.demo_rows)
        x = self.encode(batch.observation, batch.state)
        clone(self.sac, x, batch.action, self.generator)
        self.sac.reset_optimisers()
        return True

    def _demonstration_rows(self) -> Tensor | None:
        shown, seeds = self.shown, self.settings.seeds
        if self.settings.demo_replay == 0 and self.settings.warm_start == "none":
            return None
        if len(shown.observation) == 0:
            return None
        before = torch.from_numpy(shown.observation).expand(seeds, -1, -1)
        after = torch.from_numpy(shown.next_observation).expand(seeds, -1, -1)
        if shown.action is None and len(self.replay) == 0:
            problem = "actions cannot be inferred before a step was taken"
            help = "take random steps first, 2,000 for instance"
            raise CompileError(
                Diagnostic.of("JOB604", setting="learning_starts", problem=problem, help=help)
            )
        if shown.action is None:
            inverse = fit_inverse_dynamics(self.replay, self.layout, self.generator)
            action = inverse(before, after)
        else:
            scaled = 2 * (shown.action - self.low) / (self.high - self.low) - 1
            action = torch.from_numpy(scaled.astype(np.float32)).expand(seeds, -1, -1)
        columns = [
            before,
            action,
            after,
            torch.from_numpy(shown.state)[:, None].expand(seeds, -1, -1),
            torch.from_numpy(shown.letter)[:, None].expand(seeds, -1, -1),
            torch.zeros(seeds, len(shown.state), 1),
        ]
        return torch.cat([c.float() for c in columns], dim=-1)

    def learn(self, progress: float) -> dict[str, Tensor]:
        """One update of discriminators, critics, actor and targets; losses by seed.

        `progress` counts environment steps since learning began.
        """
        s = self.settings
        gone = progress / max(s.steps - s.learning_starts, 1)
        self.sac.slow(1 - (1 - s.final_rate) * gone)
        losses = {}
        if self.judges:
            losses["discriminator"] = self.discriminators.update()
        batch, shown = self._batch()
        x = self.encode(batch.observation, batch.state)
        losses["critic"] = self.sac.update_critics(x, batch.action, self.targets(batch))
        losses["actor"] = self.sac.update_actor(x, imitated=self._imitated(batch, shown, progress))
        self.sac.follow()
        return losses

    def _batch(self) -> tuple[Batch, int]:
        """A batch of which the first `shown` rows are demonstrations'."""
        s = self.settings
        shown = round(s.demo_replay * s.batch_size) if self.demo_rows is not None else 0
        rows = self.replay.sample(s.batch_size - shown, self.generator)
        if shown and self.demo_rows is not None:
            count = self.demo_rows.shape[1]
            at = torch.randint(count, (s.seeds, shown, 1), generator=self.generator)
            drawn = self.demo_rows.gather(1, at.expand(-1, -1, self.demo_rows.shape[2]))
            rows = torch.cat([drawn, rows], dim=1)
        batch = self.layout.unpack(rows)
        return (self._relabelled(batch, shown) if s.relabel else batch), shown

    def _relabelled(self, batch: Batch, shown: int) -> Batch:
        """The batch with RELABELLED of the agent's own steps read from any live state instead."""
        shape = batch.state.shape
        drawn = torch.randint(len(self.live), shape, generator=self.generator)
        kept = torch.rand(shape, generator=self.generator) >= RELABELLED
        kept[:, :shown] = True
        return replace(batch, state=torch.where(kept, batch.state, self.live[drawn]))

    def targets(self, batch: Batch) -> Tensor:
        """Eq. 4 with the rewards of today's discriminators, [seed, n]."""
        reward = self._reward(batch.observation, batch.state)
        options = self.options[batch.state, batch.letter]
        value = self._option_values(batch.next_observation, options, greedy=False)
        wait = self._wait(batch.next_observation, options)
        return tiloil_target(
            self.table,
            batch.state,
            reward,
            options,
            value,
            batch.terminal,
            self.settings,
            wait,
        )

    def _reward(self, observation: Tensor, state: Tensor) -> Tensor:
        """Eq. 8 of (s, b) with today's discriminators, [seed, n]."""
        bonus = torch.zeros(())
        if self.judges:
            bonus = self.discriminators.bonus(observation, self.table.code[state])
        return stage_reward(self.table, state, bonus, self.settings)

    def _wait(self, observation: Tensor, options: Tensor) -> Tensor | None:
        """What is paid for a jump that takes a step; None where jumps do not."""
        return self._reward(observation, options[..., 0]) if self.walk.costly else None

    def _imitated(self, batch: Batch, shown: int, progress: float) -> Imitated | None:
        """The demonstrations' rows of a batch, and what cloning them still weighs."""
        s = self.settings
        if s.warm_start == "none" or not shown or progress >= s.warm_start_steps:
            return None
        weight = (1 - progress / s.warm_start_steps) / (1 - s.gamma)
        return Imitated(batch.action[:, :shown], torch.tensor(weight))

    def policy(self) -> State:
        """What acting needs; each tensor's first axis counts seeds, or seeds times two."""
        return self.sac.policy()

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.sac.load_policy(state)

    def rings(self) -> dict[str, Ring]:
        """The replay's rows and the stage buffers' states."""
        return {"replay": self.replay.ring(), "stages": self.buffers.ring()}

    def state(self) -> State:
        """Everything else that learning goes on from."""
        state = {
            **with_prefix("sac", self.sac.state()),
            **with_prefix("discriminators", self.discriminators.state()),
            **with_prefix("stages", self.buffers.state()),
            **with_prefix("replay", self.replay.state()),
            "generator": self.generator.get_state(),
        }
        if self.demo_rows is not None:
            state["demo_rows"] = self.demo_rows
        return state

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.sac.load(under("sac", state))
        self.discriminators.load(under("discriminators", state))
        self.buffers.load(under("stages", state))
        self.replay.load(under("replay", state))
        self.generator.set_state(state["generator"])
        self.demo_rows = state.get("demo_rows")

    def _to_environment(self, action: Floats) -> Floats:
        scaled = self.low + 0.5 * (action + 1) * (self.high - self.low)
        shape = (*action.shape[:2], *self.action_shape)
        return scaled.reshape(shape).astype(np.float32)


def _scale(space: Space[Any], shown: Shown) -> tuple[Tensor, Tensor]:
    """Middle and half-width of each observation: its bounds, or its spread in demonstrations."""
    d = shown.positive.shape[1]
    low, high = getattr(space, "low", None), getattr(space, "high", None)
    if low is None or high is None:
        low, high = np.full(d, -np.inf), np.full(d, np.inf)
    low, high = low.reshape(-1), high.reshape(-1)
    bounded = np.isfinite(low) & np.isfinite(high) & (high - low < 1e6)
    seen = shown.positive if len(shown.positive) else np.zeros((1, len(low)), np.float32)
    with np.errstate(invalid="ignore", over="ignore"):
        middle = np.where(bounded, (low + high) / 2, seen.mean(0))
        half = np.where(bounded, (high - low) / 2, seen.std(0))
    half = np.where(half > 1e-6, half, 1.0)
    return torch.from_numpy(middle.astype(np.float32)), torch.from_numpy(half.astype(np.float32))
