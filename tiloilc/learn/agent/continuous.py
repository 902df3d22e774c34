"""The agent on continuous tasks: SAC on the product, with the targets of an algorithm."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.agent.cloning import clone, demonstrated_rows, infer_again
from tiloilc.learn.agent.held import Held
from tiloilc.learn.agent.shown import Shown, judged_demonstrations, strange_states
from tiloilc.learn.algorithm.method import Setup, arrivals_of, make_method, rewards_of
from tiloilc.learn.algorithm.tiloil import input_states
from tiloilc.learn.engine.chance import Chance, draw_shown, draw_states
from tiloilc.learn.engine.device import check_memory, memory_of
from tiloilc.learn.engine.inputs import Inputs
from tiloilc.learn.engine.program import Program, Say, pays
from tiloilc.learn.engine.replay import Batch, Layout, Replay
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.sac import Imitated, SoftActorCritic
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import ALGORITHMS, Settings

if TYPE_CHECKING:
    from gymnasium.spaces import Box, Space


HOST_SEED = 2**31
"""Keeps the noise of actions apart from what learning draws; of a seed 32 bits count."""


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
        horizon: int,
        generator: torch.Generator,
        say: Say = lambda text: None,
    ) -> None:
        self.settings, self.walk, self.shown, self.generator = settings, walk, shown, generator
        device = generator.device
        self.host = torch.Generator().manual_seed(generator.initial_seed() + HOST_SEED)
        d, m = shown.observation.shape[1], int(np.prod(action_space.shape))
        self.low, self.high = action_space.low.reshape(-1), action_space.high.reshape(-1)
        self.action_shape = action_space.shape
        self.code = input_states(walk, settings).to(device)
        self.encode = Inputs(observation_space, shown.positive, self.code, walk.states)
        self.options = torch.from_numpy(walk.options).to(device)
        live = [b for b in range(walk.states) if b != walk.sink]
        self.live = self.code[live].unique()
        seeds, buffers = settings.seeds, stages.sink_buffer + 1
        self.sac = SoftActorCritic(seeds, d + walk.states, m, settings, generator)
        self.memory = memory_of(settings, Layout(d, m).width, d, buffers, self.sac.networks)
        check_memory(self.memory, device, settings)
        capacity = min(settings.buffer_size, settings.steps)
        positive = torch.from_numpy(shown.positive).to(device)
        setup = Setup(settings, stages, walk, positive, capacity, horizon, generator)
        self.method = make_method(setup)
        self.layout = Layout(d, m, self.method.columns)
        self.replay = Replay(seeds, capacity, self.layout.width, device)
        self.held = Held(self.layout)
        self.exploration = 0.0 if settings.exploration == "auto" else settings.exploration
        self.cloning_weight = torch.zeros((), device=device)
        self.strange = torch.from_numpy(strange_states(walk, shown)).to(device)
        self.reluctance = torch.zeros(seeds, walk.states, device=device)
        settled = settings.algorithm in ALGORITHMS  # who knows what others keep
        self.program = Program(self._update, pays(settings), settled, say)
        self._show(None)

    def _show(self, rows: Tensor | None) -> None:
        """Have `rows` of demonstrations in every batch from now on, as many as wanted."""
        self.demo_rows = None if rows is None else rows.to(self.generator.device)
        share = self.settings.demo_replay if rows is not None else 0
        self.shown_rows = round(share * self.settings.batch_size)

    def act(self, observations: Floats, states: Int, greedy: bool) -> Floats:
        """Actions in the environment's units, [seed, copy, …]."""
        seen = self.encode.on_host(observations, states)
        if greedy:
            return self._to_environment(self.sac.act(seen, None))
        shape = (*states.shape, len(self.low))
        action = self.sac.act(seen, torch.randn(shape, generator=self.host).numpy())
        if self.exploration > 0:
            stray = torch.rand((*states.shape, 1), generator=self.host) < self.exploration
            anything = 2 * torch.rand(shape, generator=self.host) - 1
            action = np.where(stray.numpy(), anything.numpy(), action)
        return self._to_environment(action)

    def explore(self, rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
        """Uniformly random actions, [seed, copy, …]."""
        drawn = rng.uniform(-1, 1, (*shape, len(self.low))).astype(np.float32)
        return self._to_environment(drawn)

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        """The option of greatest value (drawn by softmax of value / α while exploring)."""
        if (options == options[..., :1]).all():  # most often there is nothing to choose
            return options[..., 0]
        device = self.generator.device
        offered = torch.from_numpy(options).to(device)
        seen = torch.from_numpy(observations).to(device)
        x = self._encode_options(seen, offered)
        value = self.sac.greedy_value(x) if greedy else self.sac.soft_value(x)
        value = self.method.worth(seen, offered).each(value.view_as(offered))
        value = value - self.reluctance.gather(1, offered.flatten(1)).view_as(value)
        if not greedy:
            noise = torch.rand(value.shape, generator=self.generator, device=device)
            alpha = self.sac.log_alpha.exp()[:, None, None]
            filled = offered == offered[..., :1]  # rows are filled up with their first option
            filled[..., 0] = False
            value = value - alpha * (-noise.clamp(1e-9, 1 - 1e-9).log()).log()
            value = value.masked_fill(filled, -torch.inf)
        chosen = offered.gather(-1, value.argmax(-1, keepdim=True))
        return chosen.squeeze(-1).cpu().numpy()

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
        arrived: Int,
    ) -> None:
        """Store one transition of each copy, all [seed, copy, …], or hold it until it is judged."""
        flat = action.reshape(*state.shape, -1)
        scaled = 2 * (flat - self.low) / (self.high - self.low) - 1
        rows = self.layout.pack(observation, scaled, after, state, letter, terminal)
        if self.layout.kept:
            self.held.add(rows, arrived)
        else:
            self.replay.add(rows)
        self.method.see(after, state, arrived)

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Take in a finished segment's states."""
        self.method.segment(seed, buffer, observations)

    def finish(self, over: NDArray[np.bool_], length: Int) -> None:
        """Episodes have ended: they can be judged, if the algorithm does."""
        if self.layout.kept:
            self.replay.add(self.held.finish(self.method, over, length))

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
                    judged_demonstrations(self.method, self.shown),
                    self.generator,
                )
            )
        if self.demo_rows is None or not clones:
            return False
        self._clone(self.demo_rows)
        self._weigh_cloning(1)
        return True

    def infer(self, cloning: bool) -> None:
        """Give the demonstrations actions by what the agent has done by now; clone them again."""
        if self.demo_rows is None or self.shown.action is not None:
            return
        infer_again(self.demo_rows, self.replay, self.layout, self.generator)
        if cloning and self.settings.warm_start != "none":
            self._clone(self.demo_rows)

    def _clone(self, rows: Tensor) -> None:
        """Have the actor do what `rows` of demonstrations do."""
        batch = self.layout.unpack(rows)
        x = self.encode(batch.observation, batch.state)
        clone(self.sac, x, batch.action, self.generator)
        self.sac.reset_optimisers()

    def _weigh_cloning(self, share: float) -> None:
        """Have imitation weigh `share` of what rewards of 1 for ever are worth.

        Nobody is to jump where no demonstration was: the cloned actor does not know what to do.
        """
        weight = share / (1 - self.settings.gamma)
        self.cloning_weight.fill_(weight)
        if self.walk.chooses:
            self.reluctance.copy_((weight * self.strange).expand_as(self.reluctance))

    def learn(self, progress: float) -> dict[str, Tensor]:
        """One update, `progress` environment steps since learning began; losses by seed."""
        if len(self.replay) == 0:  # the first episode is not judged yet
            return {}
        s = self.settings
        gone = min(progress / max(s.steps - s.learning_starts, 1), 1)  # copies end a little later
        self.sac.slow(1 - (1 - s.final_rate) * gone)
        if s.warm_start != "none":
            self._weigh_cloning(max(1 - progress / max(s.warm_start_steps, 1), 0))
        return self.program(self._draw())

    def _draw(self) -> Chance:
        """What the next update needs of chance."""
        s, random = self.settings, self.generator
        rows = self.replay.draw(s.batch_size - self.shown_rows, random)
        shown, state = draw_shown(self.demo_rows, self.shown_rows, random), None
        if s.relabel:
            state = draw_states(self.live, (s.seeds, s.batch_size), self.shown_rows, random)
        noise = self.sac.noise(s.batch_size * (self.options.shape[2] + 1))
        return Chance(rows, shown, state, noise, self.method.draw())

    def _update(self, chance: Chance) -> dict[str, Tensor]:
        """Algorithm 1, lines 16 to 24: discriminators, critics, actor and targets."""
        losses = self.method.learn(chance.method)
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
        target = self.method.backup(batch, options).best(value)
        losses["critic"] = self.sac.update_critics(x, batch.action, target)
        imitated = None
        if chance.shown is not None and self.settings.warm_start != "none":
            imitated = Imitated(batch.action[:, : self.shown_rows], self.cloning_weight)
        losses["actor"] = self.sac.update_actor(x, now, imitated)
        self.sac.follow()
        return losses

    def _batch(self, chance: Chance) -> Batch:
        """A batch of which the first rows are demonstrations'."""
        rows = self.replay.at(chance.rows)
        if chance.shown is not None and self.demo_rows is not None:
            places = chance.shown.expand(-1, -1, self.layout.width)
            rows = torch.cat([self.demo_rows.gather(1, places), rows], dim=1)
        batch = self.layout.unpack(rows, self.shown_rows)
        if chance.state is None:
            return batch
        read = torch.where(chance.state < 0, batch.state, chance.state)
        return replace(batch, state=read)

    def policy(self) -> State:
        """What acting needs; each tensor's first axis counts seeds, or seeds times two."""
        method = self.method
        arrivals = arrivals_of(method, self.walk, self.settings.seeds, self.encode.middle)
        if arrivals:
            arrivals["pay"] = arrivals["pay"] - self.reluctance
        more = {**with_prefix("method", method.policy()), **with_prefix("arrival", arrivals)}
        more["reluctance"] = self.reluctance
        return {name: tensor.cpu() for name, tensor in {**self.sac.policy(), **more}.items()}

    def fixed(self) -> State:
        """Scales of observations and actions, and what networks are told of automaton states."""
        return {
            "middle": self.encode.middle.cpu(),
            "half": self.encode.half.cpu(),
            "low": torch.from_numpy(self.low.reshape(self.action_shape)),
            "high": torch.from_numpy(self.high.reshape(self.action_shape)),
            "code": self.code.cpu(),
        }

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.sac.load_policy(state)
        self.method.load_policy(under("method", state))
        none = torch.zeros_like(self.reluctance)  # older runs have none
        self.reluctance.copy_(state.get("reluctance", none))

    def rings(self) -> dict[str, Ring]:
        """The replay's rows, and what the algorithm keeps."""
        return {"replay": self.replay.ring(), **with_prefix("method", self.method.rings())}

    def rewards(self, observations: Floats) -> Tensor:
        """What the algorithm pays for s [n, d] in each automaton state b: [seed, b, n]."""
        seen = torch.from_numpy(observations).to(self.generator.device)
        return rewards_of(self.method, seen, self.settings.seeds, self.walk.states)

    def state(self) -> State:
        """Everything else that learning goes on from."""
        state = {
            **with_prefix("sac", self.sac.state()),
            **with_prefix("method", self.method.state()),
            **with_prefix("replay", self.replay.state()),
            **with_prefix("held", self.held.state()),
            "generator": self.generator.get_state(),
            "host": self.host.get_state(),
            "compiled": torch.tensor(self.program.compiled),
            "reluctance": self.reluctance,
        }
        if self.demo_rows is not None:
            state["demo_rows"] = self.demo_rows
        return state

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.sac.load(under("sac", state))
        self.method.load(under("method", state))
        self.replay.load(under("replay", state))
        self.held.load(under("held", state))
        self.generator.set_state(state["generator"])
        self.host.set_state(state["host"])
        self.program.compiled = bool(state["compiled"])
        self.reluctance.copy_(state["reluctance"])
        self._show(state.get("demo_rows"))

    def _to_environment(self, action: Floats) -> Floats:
        scaled = self.low + 0.5 * (action + 1) * (self.high - self.low)
        shape = (*action.shape[:2], *self.action_shape)
        return scaled.reshape(shape).astype(np.float32)
