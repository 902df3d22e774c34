"""The agent on finite tasks: tabular soft Q-learning with TiLoIL's rewards and targets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.agent.shown import Shown
from tiloilc.learn.algorithm.counts import CountDiscriminators
from tiloilc.learn.algorithm.tiloil import (
    StageTable,
    exact_values,
    option_values,
    stage_reward,
    tiloil_target,
)
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import Settings

if TYPE_CHECKING:
    from gymnasium.spaces import Discrete, Space


@dataclass(frozen=True, slots=True)
class Steps:
    """One step of every copy, [seed, copy]; `valid` says which copies it belongs to."""

    cell: Tensor
    action: Tensor
    after: Tensor
    state: Tensor
    letter: Tensor
    terminal: Tensor
    valid: Tensor

    def where(self, mask: Tensor) -> Steps:
        """The step for the copies of `mask` only."""
        return replace(self, valid=mask)


class TabularAgent:
    """Q [seed, cell, automaton state, action]; an episode is learned backwards when it ends.

    With a temperature α the policy is π ∝ exp(Q / α), and a state is worth what theorem 3.2 takes
    for granted, E_π[Q − α log π] = α log Σ exp(Q / α). With α = 0 that is the greatest Q. `tuned`
    moves α until π has the target entropy; no π has a negative one, so then α is 0 from the start.

    With `relabel` each step teaches every live automaton state, not just the one the agent was in:
    labels do not depend on it (counterfactual experience, as in LCER).
    """

    def __init__(
        self,
        settings: Settings,
        stages: Stages,
        walk: Walk,
        observation_space: Space[Any],
        action_space: Discrete,
        shown: Shown,
        generator: torch.Generator,
    ) -> None:
        self.settings, self.walk, self.generator = settings, walk, generator
        self.low, self.sizes = _cells_of(observation_space)
        self.first_action, self.actions = int(action_space.start), int(action_space.n)
        cells = int(np.prod(self.sizes))
        self.table = StageTable.of(stages, walk, settings)
        optimistic = settings.optimistic
        if optimistic == "auto":
            optimistic = settings.demo_replay == 0 or len(shown.observation) == 0
        first = 1 / (1 - settings.gamma) if optimistic else 0.0
        self.q = torch.full((settings.seeds, cells, walk.states, self.actions), first)
        self.discriminators = CountDiscriminators(
            stages, cells, self._cells(shown.positive), settings
        )
        self.tuned = settings.entropy == "tuned" and settings.target_entropy > 0
        alpha = 0.0 if settings.entropy == "tuned" else float(settings.entropy)
        self.alpha = torch.full((settings.seeds,), 1.0 if self.tuned else alpha)
        self.live = torch.tensor([b for b in range(walk.states) if b != walk.sink])
        self.options = torch.from_numpy(walk.options)
        self.floor = self._demonstrated_values(shown, cells)
        self.open: list[Steps] = []
        self.closed: list[Steps] = []

    def act(self, observations: Floats, states: Int, greedy: bool) -> Int:
        """The action of greatest value, ties at random; while learning sometimes any action."""
        seed = torch.arange(len(states))[:, None]
        values = self.q[seed, torch.from_numpy(self._cells(observations)), self.table.code[states]]
        if greedy:
            return values.argmax(-1).numpy() + self.first_action
        noise = torch.rand(values.shape, generator=self.generator)
        best = torch.where(values == values.amax(-1, keepdim=True), noise, -1.0).argmax(-1)
        if (self.alpha > 0).any():  # the greatest Q + α · Gumbel is drawn from π
            gumbel = -(-noise.clamp(1e-9, 1 - 1e-7).log()).log()
            best = (values + self.alpha[:, None, None] * gumbel).argmax(-1)
        anything = torch.randint(self.actions, best.shape, generator=self.generator)
        stray = torch.rand(best.shape, generator=self.generator) < self.settings.exploration
        return torch.where(stray, anything, best).numpy() + self.first_action

    def explore(self, rng: np.random.Generator, shape: tuple[int, int]) -> Int:
        """Uniformly random actions."""
        return rng.integers(self.actions, size=shape) + self.first_action

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        """The option of greatest value."""
        offered = torch.from_numpy(options)
        seed = torch.arange(len(options))[:, None, None]
        cells = torch.from_numpy(self._cells(observations))[..., None]
        soft = self._value(seed, cells, offered)
        wait = self._wait(seed[..., 0], cells[..., 0], offered)
        value = option_values(self.table, offered, soft, self.settings, wait)
        return offered.gather(-1, value.argmax(-1, keepdim=True)).squeeze(-1).numpy()

    def record(
        self,
        observation: Floats,
        action: Int,
        after: Floats,
        state: Int,
        letter: Int,
        terminal: NDArray[np.bool_],
    ) -> None:
        """Keep one step of each copy until its episode ends."""
        columns = (
            self._cells(observation),
            action - self.first_action,
            self._cells(after),
            state,
            letter,
            terminal,
            np.ones(state.shape, dtype=np.bool_),
        )
        parts = [torch.from_numpy(np.ascontiguousarray(column)) for column in columns]
        self.open.append(Steps(*parts))

    def finish(self, over: NDArray[np.bool_], length: Int) -> None:
        """The episodes of the copies in `over` [seed, copy] ended after `length` steps."""
        ended = torch.from_numpy(over)
        if not over.any():
            return
        longest = int(length[over].max())
        steps = self.open[-longest:]
        age = torch.from_numpy(length)
        self.closed += [step.where(ended & (age > k)) for k, step in enumerate(reversed(steps))]
        running = int(length[~over].max(initial=0))
        self.open = self.open[len(self.open) - running :]

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Count a finished segment's states in its stage buffer."""
        cells = torch.from_numpy(self._cells(observations))
        self.discriminators.counts[seed, buffer] += torch.bincount(cells, minlength=self.q.shape[1])

    def begin(self) -> bool:
        """Nothing is cloned; what was collected at random is learned with the next episode."""
        return False

    def learn(self, progress: float) -> dict[str, Tensor]:
        """Learn the latest step, or backwards the episodes that it ended; how far Q moved."""
        if self.closed:
            self.discriminators.refresh()
            steps, self.closed = self.closed, []
        else:
            steps = self.open[-1:]
        moved = [self._learn_step(step) for step in steps]
        return {"change": torch.stack(moved).mean(0)} if moved else {}

    def policy(self) -> State:
        """What acting needs; each tensor's first axis counts seeds."""
        judges = {"values": self.discriminators.values} if self.walk.costly else {}
        return {"q": self.q, "alpha": self.alpha, **judges}

    def fixed(self) -> State:
        """How cells are numbered, and what is known of cells and automaton states."""
        return {
            "low": torch.from_numpy(self.low),
            "sizes": torch.from_numpy(self.sizes),
            "first_action": torch.tensor(self.first_action),
            "code": self.table.code,
            "entry": exact_values(self.table, self.settings),
            "floor": self.floor,
        }

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.q.copy_(state["q"])
        self.alpha.copy_(state["alpha"])
        if self.walk.costly:  # jumps that take a step are paid by them
            self.discriminators.values.copy_(state["values"])

    def rings(self) -> dict[str, Ring]:
        """None: counts are kept instead of rows."""
        return {}

    def rewards(self, observations: Floats) -> Tensor:
        """Eq. 8 of s [n, d] in each automaton state b, by today's discriminators: [seed, b, n]."""
        seed, state = torch.arange(self.settings.seeds), torch.arange(self.walk.states)
        cell = torch.from_numpy(self._cells(observations))
        return torch.stack(
            [self._reward(s.expand(1, 1), cell[:, None], state[None]).T for s in seed]
        )

    def state(self) -> State:
        """Everything that learning goes on from."""
        return {
            **self.policy(),
            "counts": self.discriminators.counts,
            "values": self.discriminators.values,
            "generator": self.generator.get_state(),
            **with_prefix("open", _stacked(self.open)),
            **with_prefix("closed", _stacked(self.closed)),
        }

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.load_policy(state)
        self.discriminators.counts.copy_(state["counts"])
        self.discriminators.values.copy_(state["values"])
        self.generator.set_state(state["generator"])
        self.open = _unstacked(under("open", state))
        self.closed = _unstacked(under("closed", state))

    def _learn_step(self, step: Steps) -> Tensor:
        """Move Q towards Eq. 4 for one step of each copy that has it."""
        s = self.settings
        seed, copy = step.valid.nonzero(as_tuple=True)
        cell, action, after = (x[seed, copy] for x in (step.cell, step.action, step.after))
        state = step.state[seed, copy][:, None]
        if s.relabel:
            state = self.live.expand(len(seed), -1)
        options = self.options[state, step.letter[seed, copy][:, None]]
        soft = self._value(seed[:, None, None], after[:, None, None], options)
        reward = self._reward(seed[:, None], cell[:, None], state)
        wait = self._wait(seed[:, None], after[:, None], options)
        terminal = step.terminal[seed, copy][:, None].expand_as(state)
        target = tiloil_target(self.table, state, reward, options, soft, terminal, s, wait)
        at = (seed[:, None], cell[:, None], self.table.code[state], action[:, None])
        gap = s.learning_rate * (target - self.q[at])
        self.q[at] += gap
        if self.tuned:
            self._tune(seed, self.q[at[:3]])
        return torch.zeros(s.seeds).index_add_(0, seed, gap.abs().mean(1))

    def _value(self, seed: Tensor, cell: Tensor, state: Tensor) -> Tensor:
        """V(s, b), no less than what demonstrations show; all of one shape, or broadcast to it."""
        arrived = self.table.code[state]
        q = self.q[seed, cell, arrived]
        alpha = self.alpha[seed].expand(q.shape[:-1])
        soft = alpha * (q / alpha.clamp(min=1e-30)[..., None]).logsumexp(-1)
        return torch.where(alpha > 0, soft, q.amax(-1)).maximum(self.floor[cell, arrived])

    def _reward(self, seed: Tensor, cell: Tensor, state: Tensor) -> Tensor:
        """Eq. 8 of (s, b) with today's discriminators."""
        bonus = self.discriminators.bonus(seed, cell, self.table.code[state])
        return stage_reward(self.table, state, bonus, self.settings)

    def _wait(self, seed: Tensor, cell: Tensor, options: Tensor) -> Tensor | None:
        """What is paid for a jump that takes a step; None where jumps do not."""
        return self._reward(seed, cell, options[..., 0]) if self.walk.costly else None

    def _tune(self, seed: Tensor, q: Tensor) -> None:
        """Move each seed's α by how far π's entropy is from its target; q is [n, states, A]."""
        log_pi = (q / self.alpha[seed][:, None, None]).log_softmax(-1)
        missing = self.settings.target_entropy + (log_pi.exp() * log_pi).sum(-1).mean(1)
        count = torch.zeros_like(self.alpha).index_add_(0, seed, torch.ones(len(seed)))
        gap = torch.zeros_like(self.alpha).index_add_(0, seed, missing) / count.clamp(min=1)
        limit = 1 / (1 - self.settings.gamma)
        self.alpha.mul_((self.settings.critic_rate * gap).exp()).clamp_(1e-6, limit)

    def _demonstrated_values(self, shown: Shown, cells: int) -> Tensor:
        """What demonstrated states are worth at least, [cell, automaton state].

        A demonstration shows that some action leads from each of its states to the next, whichever
        it is. Its return under Eq. 4, with the least reward that any discriminator could give, is a
        lower bound of the value where the environment is deterministic.
        """
        floor = torch.full((cells, self.walk.states), -torch.inf)
        if self.settings.demo_replay == 0:
            return floor
        before, after = self._cells(shown.observation), self._cells(shown.next_observation)
        state = self.live[None]
        code = self.table.code[state]
        least = stage_reward(self.table, state, torch.tensor(-1.0), self.settings)
        never = torch.zeros_like(state, dtype=torch.bool)
        for t in reversed(range(len(before))):
            options = self.options[state, int(shown.letter[t])]
            soft = floor[int(after[t]), self.table.code[options]]
            wait = None
            if self.walk.costly:
                wait = stage_reward(self.table, options[..., 0], torch.tensor(-1.0), self.settings)
            value = tiloil_target(
                self.table, state, least, options, soft, never, self.settings, wait
            )
            at = (int(before[t]), code)
            floor[at] = floor[at].maximum(value)
        return floor

    def _cells(self, observations: Floats) -> Int:
        """The number of each observation [..., d] among all cells."""
        whole = np.moveaxis(observations.astype(np.int64) - self.low, -1, 0)
        cells: Int = np.ravel_multi_index(tuple(whole), tuple(self.sizes))
        return cells


def _cells_of(space: Space[Any]) -> tuple[Int, Int]:
    """The least value of each observed number, and how many values it has."""
    from gymnasium import spaces

    if isinstance(space, spaces.Discrete):
        return np.array([space.start]), np.array([space.n])
    if isinstance(space, spaces.MultiDiscrete):
        return space.start.reshape(-1).astype(np.int64), space.nvec.reshape(-1).astype(np.int64)
    if isinstance(space, spaces.MultiBinary):
        return np.zeros(space.shape, np.int64).reshape(-1), np.full(prod(space.shape), 2)
    assert isinstance(space, spaces.Box)
    low = space.low.reshape(-1).astype(np.int64)
    return low, space.high.reshape(-1).astype(np.int64) - low + 1


def _stacked(steps: list[Steps]) -> State:
    """Steps as one tensor for each of their parts."""
    if not steps:
        return {}
    return {name: torch.stack([getattr(s, name) for s in steps]) for name in Steps.__slots__}


def _unstacked(state: State) -> list[Steps]:
    """The steps that `_stacked` was given."""
    if not state:
        return []
    parts = [state[name].unbind() for name in Steps.__slots__]
    return [Steps(*step) for step in zip(*parts, strict=True)]
