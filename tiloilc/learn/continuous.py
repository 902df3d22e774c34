"""The agent on continuous tasks: SAC on the product with TiLoIL's rewards and targets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.cloning import clone, demonstrated_rows
from tiloilc.learn.discriminators import Discriminators, Draws, StageBuffers
from tiloilc.learn.replay import Batch, Layout, Replay
from tiloilc.learn.ring import Ring
from tiloilc.learn.sac import Imitated, SoftActorCritic
from tiloilc.learn.shown import Shown
from tiloilc.learn.state import State, under, with_prefix
from tiloilc.learn.tiloil import (
    StageTable,
    exact_values,
    option_values,
    stage_reward,
    tiloil_target,
)
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import Settings

if TYPE_CHECKING:
    from gymnasium.spaces import Box, Space


RELABELLED = 0.5
"""How many steps of a batch are read from an automaton state drawn at random, with `relabel`."""


@dataclass(frozen=True, slots=True)
class Chance:
    """The random part of an update.

    Places in the replay [seed, n − n'] and among the demonstrations [seed, n', 1]; automaton states
    from which steps are read instead [seed, n], -1 for their own; noise of the actions of each
    option and of each state [seed, n·(K + 1), m].
    """

    rows: Tensor
    shown: Tensor | None
    state: Tensor | None
    noise: Tensor
    discriminators: Draws | None


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
        self._show(None)

    def _show(self, rows: Tensor | None) -> None:
        """Have `rows` of demonstrations in every batch from now on, as many as wanted."""
        self.demo_rows = rows
        share = self.settings.demo_replay if rows is not None else 0
        self.shown_rows = round(share * self.settings.batch_size)

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
        x = self._encode_options(seen, offered)
        value = self.sac.greedy_value(x) if greedy else self.sac.soft_value(x)
        value = value.view_as(offered)
        value = option_values(self.table, offered, value, self.settings, self._wait(seen, offered))
        if not greedy:
            noise = torch.rand(value.shape, generator=self.generator).clamp(1e-9, 1 - 1e-9)
            alpha = self.sac.log_alpha.exp()[:, None, None]
            filled = offered == offered[..., :1]  # rows are filled up with their first option
            filled[..., 0] = False
            value = (value - alpha * (-noise.log()).log()).masked_fill(filled, -torch.inf)
        return offered.gather(-1, value.argmax(-1, keepdim=True)).squeeze(-1).numpy()

    def _encode_options(self, observation: Tensor, options: Tensor) -> Tensor:
        """The networks' input for each option, [seed, n·K, d + states]."""
        repeated = observation.repeat_interleave(options.shape[2], dim=1)
        return self.encode(repeated, options.flatten(1))

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
        clones = self.settings.warm_start != "none"
        if clones or self.settings.demo_replay > 0:
            self._show(
                demonstrated_rows(
                    self.shown,
                    self.replay,
                    self.layout,
                    self.low,
                    self.high,
                    self.generator,
                )
            )
        if self.demo_rows is None or not clones:
            return False
        batch = self.layout.unpack(self.demo_rows)
        x = self.encode(batch.observation, batch.state)
        clone(self.sac, x, batch.action, self.generator)
        self.sac.reset_optimisers()
        return True

    def learn(self, progress: float) -> dict[str, Tensor]:
        """One update, `progress` environment steps since learning began; losses by seed."""
        s, weight = self.settings, 0.0
        gone = progress / max(s.steps - s.learning_starts, 1)
        self.sac.slow(1 - (1 - s.final_rate) * gone)
        if s.warm_start != "none":
            weight = max(1 - progress / max(s.warm_start_steps, 1), 0) / (1 - s.gamma)
        return self._update(self._draw(), torch.tensor(weight, device=self.generator.device))

    def _draw(self) -> Chance:
        """What the next update needs of chance."""
        s, random, shown = self.settings, self.generator, None
        rows = self.replay.draw(s.batch_size - self.shown_rows, random)
        if self.demo_rows is not None and self.shown_rows:
            places = (s.seeds, self.shown_rows, 1)
            shown = torch.randint(
                self.demo_rows.shape[1], places, generator=random, device=random.device
            )
        state = None
        if s.relabel:
            shape = (s.seeds, s.batch_size)
            state = self.live[
                torch.randint(len(self.live), shape, generator=random, device=random.device)
            ]
            kept = torch.rand(shape, generator=random, device=random.device) >= RELABELLED
            kept[:, : self.shown_rows] = True
            state = state.masked_fill(kept, -1)
        noise = self.sac.noise(s.batch_size * (self.options.shape[2] + 1))
        judged = self.discriminators.draw() if self.judges else None
        return Chance(rows, shown, state, noise, judged)

    def _update(self, chance: Chance, weight: Tensor) -> dict[str, Tensor]:
        """Algorithm 1, lines 16 to 24: discriminators, critics, actor and targets.

        `weight` is what imitating the demonstrations in the batch still weighs.
        """
        losses = {}
        if chance.discriminators is not None:
            losses["discriminator"] = self.discriminators.update(chance.discriminators)
        batch = self._batch(chance)
        x = self.encode(batch.observation, batch.state)
        options = self.options[batch.state, batch.letter]
        arrived = self._encode_options(batch.next_observation, options)
        drawn = self.sac.sample(torch.cat([arrived, x], dim=1), chance.noise)
        later, now = (
            drawn.rows(slice(0, arrived.shape[1])),
            drawn.rows(slice(arrived.shape[1], None)),
        )
        value = self.sac.soft_value(arrived, later).view_as(options)
        target = self.target(batch, options, value)
        losses["critic"] = self.sac.update_critics(x, batch.action, target)
        imitated = None
        if chance.shown is not None and self.settings.warm_start != "none":
            imitated = Imitated(batch.action[:, : self.shown_rows], weight)
        losses["actor"] = self.sac.update_actor(x, now, imitated)
        self.sac.follow()
        return losses

    def _batch(self, chance: Chance) -> Batch:
        """A batch of which the first rows are demonstrations'."""
        rows = self.replay.at(chance.rows)
        if chance.shown is not None and self.demo_rows is not None:
            places = chance.shown.expand(-1, -1, self.layout.width)
            rows = torch.cat([self.demo_rows.gather(1, places), rows], dim=1)
        batch = self.layout.unpack(rows)
        if chance.state is None:
            return batch
        read = torch.where(chance.state < 0, batch.state, chance.state)
        return replace(batch, state=read)

    def target(self, batch: Batch, options: Tensor, value: Tensor) -> Tensor:
        """Eq. 4 with the rewards of today's discriminators, [seed, n].

        `value` [seed, n, K] is V(s', b') of each of the `options` b'.
        """
        reward = self._reward(batch.observation, batch.state)
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

    def policy(self) -> State:
        """What acting needs; each tensor's first axis counts seeds, or seeds times two."""
        if not (self.walk.costly and self.judges):
            return self.sac.policy()
        return {**self.sac.policy(), **with_prefix("judges", self.discriminators.policy())}

    def fixed(self) -> State:
        """Scales of observations and actions, and what is known of each automaton state."""
        return {
            "middle": self.middle,
            "half": self.half,
            "low": torch.from_numpy(self.low.reshape(self.action_shape)),
            "high": torch.from_numpy(self.high.reshape(self.action_shape)),
            "code": self.table.code,
            "entry": exact_values(self.table, self.settings),
        }

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.sac.load_policy(state)
        if self.walk.costly and self.judges:  # jumps that take a step are paid by them
            self.discriminators.load_policy(under("judges", state))

    def rings(self) -> dict[str, Ring]:
        """The replay's rows and the stage buffers' states."""
        return {"replay": self.replay.ring(), "stages": self.buffers.ring()}

    def rewards(self, observations: Floats) -> Tensor:
        """Eq. 8 of s [n, d] in each automaton state b, by today's discriminators: [seed, b, n]."""
        seeds, states, n = self.settings.seeds, self.walk.states, len(observations)
        seen = torch.from_numpy(observations).repeat(states, 1).expand(seeds, -1, -1)
        state = torch.arange(states).repeat_interleave(n).expand(seeds, -1)
        return self._reward(seen, state).view(seeds, states, n)

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
        self._show(state.get("demo_rows"))

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
