"""The agent on finite tasks: tabular Q-learning with TiLoIL's rewards and targets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.shown import Shown
from tiloilc.learn.state import State, under, with_prefix
from tiloilc.learn.tiloil import StageTable, option_values, stage_reward, tiloil_target
from tiloilc.learn.unions import stage_unions
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import Settings

if TYPE_CHECKING:
    from gymnasium.spaces import Discrete, Space

SMOOTHING = 0.5
"""Added to every count: a state that neither side has seen gets f = 0."""


class CountDiscriminators:
    """f_b in closed form: on a table the best logit is the log-ratio of the two frequencies.

    `counts` [seed, buffer, observation] holds how often each state is in each stage buffer.
    """

    def __init__(self, stages: Stages, cells: int, shown: Int, settings: Settings) -> None:
        self.settings = settings
        self.positive, self.negative = stage_unions(stages, settings.stages)
        self.counts = torch.zeros(
            settings.seeds, stages.sink_buffer + 1, cells, dtype=torch.float64
        )
        self.demonstrations = torch.bincount(torch.from_numpy(shown), minlength=cells).double()
        self.values = torch.zeros(settings.seeds, len(self.positive), cells)

    def refresh(self) -> None:
        """Bring tanh f up to date with the counts, for every stage and cell."""
        own = torch.einsum("kb,sbc->skc", self.positive.double(), self.counts)
        negative = torch.einsum("kb,sbc->skc", self.negative.double(), self.counts)
        positive = _mix(own, self.demonstrations, self.settings.demo_fraction)
        scale = positive.sum(-1, keepdim=True).clamp(min=1)
        other = negative.sum(-1, keepdim=True)
        ratio = (positive + SMOOTHING) / (negative * scale / other.clamp(min=1) + SMOOTHING)
        known = (positive.sum(-1, keepdim=True) > 0) & (other > 0)
        known &= self.positive.any(1)[:, None]
        self.values = torch.where(known, torch.tanh(ratio.log()), 0.0).float()

    def bonus(self, seed: Tensor, cell: Tensor, state: Tensor) -> Tensor:
        """tanh f_b(s), [n, states], for seeds and cells [n] and automaton states [n, states]."""
        stage = state if self.settings.stages else torch.zeros_like(state)
        return self.values[seed[:, None], stage, cell[:, None]]


def _mix(own: Tensor, shown: Tensor, share: float) -> Tensor:
    """Counts of which `share` come from demonstrations, as far as there are both."""
    total, demos = own.sum(-1, keepdim=True), shown.sum()
    if demos == 0:
        return own
    weight = torch.where(total > 0, share * total.clamp(min=1) / demos, 1.0)
    return own * torch.where(total > 0, 1 - share, 0.0) + shown * weight


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
        arrived = self.table.code[offered]
        soft = self.q[seed, cells, arrived].amax(-1).maximum(self.floor[cells, arrived])
        value = option_values(self.table, offered, soft, self.settings)
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
        return {"q": self.q}

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.q.copy_(state["q"])

    def state(self) -> State:
        """Everything that learning goes on from."""
        return {
            "q": self.q,
            "counts": self.discriminators.counts,
            "values": self.discriminators.values,
            "generator": self.generator.get_state(),
            **with_prefix("open", _stacked(self.open)),
            **with_prefix("closed", _stacked(self.closed)),
        }

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.q.copy_(state["q"])
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
        arrived = self.table.code[options]
        soft = self.q[seed[:, None, None], after[:, None, None], arrived].amax(-1)
        soft = soft.maximum(self.floor[after[:, None, None], arrived])
        code = self.table.code[state]
        bonus = self.discriminators.bonus(seed, cell, code)
        reward = stage_reward(self.table, state, bonus, s)
        terminal = step.terminal[seed, copy][:, None].expand_as(state)
        target = tiloil_target(self.table, state, reward, options, soft, terminal, s)
        at = (seed[:, None], cell[:, None], code, action[:, None])
        gap = s.learning_rate * (target - self.q[at])
        self.q[at] += gap
        return torch.zeros(s.seeds).index_add_(0, seed, gap.abs().mean(1))

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
            value = tiloil_target(self.table, state, least, options, soft, never, self.settings)
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
