"""The agent on finite tasks: tabular soft Q-learning with the targets of an algorithm."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.agent.shown import Shown, judged_demonstrations
from tiloilc.learn.agent.shown_steps import ShownSteps, shown_trail
from tiloilc.learn.agent.steps import (
    Recent,
    Trail,
    ended,
    in_each_state,
    trails_of,
    trails_state,
)  # fmt: skip
from tiloilc.learn.agent.turns import Turns
from tiloilc.learn.algorithm.method import Backup, Setup, arrivals_of, make_method, rewards_of
from tiloilc.learn.algorithm.tiloil import input_states
from tiloilc.learn.engine.cells import Cells
from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.sac import LEAST_ALPHA
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import Settings

if TYPE_CHECKING:
    from gymnasium.spaces import Discrete, Space


EXPLORATION = 0.2
"""How many actions are random, unless `exploration` says otherwise."""


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
        horizon: int,
        generator: torch.Generator,
    ) -> None:
        self.settings, self.walk, self.generator = settings, walk, generator
        self.cells = Cells.of(observation_space)
        self.first_action, self.actions = int(action_space.start), int(action_space.n)
        self.code = input_states(walk, settings)
        positive = torch.from_numpy(shown.positive)
        setup = Setup(settings, stages, walk, positive, 0, horizon, generator, self.cells)
        self.method = make_method(setup)
        share = settings.exploration
        self.exploration = EXPLORATION if share == "auto" else share
        self.tuned = settings.entropy == "tuned" and settings.target_entropy > 0
        alpha = 0.0 if settings.entropy == "tuned" else float(settings.entropy)
        self.soft = self.tuned or alpha > 0
        self.alpha = torch.full((settings.seeds,), 1.0 if self.tuned else alpha)
        live = [b for b in range(walk.states) if b != walk.sink]
        self.live = self.code[live].unique()
        self.rows = self.cells.count * walk.states  # of each seed
        self.floor = self._demonstrated_values(shown)
        self.bounded = bool(self.floor.isfinite().any())
        self.shown = None
        if settings.demo_replay > 0 and shown.lengths and not self.bounded:
            kept = judged_demonstrations(self.method, shown)
            numbers = (settings.seeds, self.actions, self.first_action)
            self.shown = ShownSteps(shown, kept, self.cells, *numbers)
        optimistic = not self.bounded if settings.optimistic == "auto" else settings.optimistic
        first = 1 / (1 - settings.gamma) if optimistic else 0.0
        shape = (settings.seeds, self.cells.count, walk.states, self.actions)
        self.q = torch.full(shape, first)
        self.table: Floats = self.q.view(-1, self.actions).numpy()  # the same numbers by row
        self.recent = Recent(horizon, self.method.columns)
        self.closed: list[Trail] = []
        self.turn = 0

    def act(self, observations: Floats, states: Int, greedy: bool) -> Int:
        """The action of greatest value, ties at random; while learning sometimes any action."""
        values = self.table[self._row(observations, states)]
        if greedy:
            return np.asarray(values.argmax(-1) + self.first_action)
        noise = torch.rand(values.shape, generator=self.generator)
        if self.soft:  # the greatest Q + α · Gumbel is drawn from π
            gumbel = -(-noise.clamp(1e-9, 1 - 1e-7).log()).log()
            best = (values + self.alpha[:, None, None].numpy() * gumbel.numpy()).argmax(-1)
        else:
            ties = values == values.max(-1, keepdims=True)
            best = np.where(ties, noise.numpy(), -1.0).argmax(-1)
        anything = torch.randint(self.actions, best.shape, generator=self.generator)
        stray = torch.rand(best.shape, generator=self.generator) < self.exploration
        return np.where(stray.numpy(), anything.numpy(), best) + self.first_action

    def explore(self, rng: np.random.Generator, shape: tuple[int, int]) -> Int:
        """Uniformly random actions."""
        return rng.integers(self.actions, size=shape) + self.first_action

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        """The option of greatest value."""
        offered, seen = torch.from_numpy(options), torch.from_numpy(observations)
        value = torch.from_numpy(self._value(self._row(observations, options)))
        worth = self.method.worth(seen, offered).each(value)
        return offered.gather(-1, worth.argmax(-1, keepdim=True)).squeeze(-1).numpy()

    def record(
        self,
        observation: Floats,
        action: Int,
        after: Floats,
        state: Int,
        letter: Int,
        terminal: NDArray[np.bool_],
        arrived: Int,
    ) -> None:
        """Keep one step of each copy until its episode ends."""
        self.turn = 0
        column = action - self.first_action
        self.recent.add(observation, column, after, state, letter, terminal, arrived)
        self.method.see(after, state, arrived)
        if self.shown is not None:
            self.shown.see(observation, column, after)

    def finish(self, over: NDArray[np.bool_], length: Int) -> None:
        """The episodes of the copies in `over` [seed, copy] ended after `length` steps."""
        if over.any():
            self.closed.append(self.recent.episodes(self.method, over, length))

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Take in a finished segment's states."""
        self.method.segment(seed, buffer, observations)

    def begin(self) -> bool:
        """Nothing is cloned; what was collected at random is learned with the next episode."""
        return False

    def infer(self, cloning: bool) -> None:
        """Demonstrated steps are learned as soon as the agent has seen them."""

    def learn(self, progress: float) -> dict[str, Tensor]:
        """Learn a copy's latest step, or backwards the episodes that ended; how far Q moved."""
        losses, trails = dict[str, Tensor](), list[Trail]()
        if self.closed:
            losses = self.method.learn(self.method.draw())
            trails, self.closed = self.closed, []
            if self.shown is not None:
                trails.append(self.shown.known(ended(trails)))
        elif not self.method.columns:  # else it is judged when its episode is over
            trails = [self.recent.last(self.turn)]
        self.turn += 1
        moved = [self._learn(trail) for trail in trails]
        return {**losses, "change": torch.stack(moved).mean(0)} if moved else losses

    def policy(self) -> State:
        """What acting needs; each tensor's first axis counts seeds."""
        method, anywhere = self.method, torch.zeros(len(self.cells.low))
        arrivals = arrivals_of(method, self.walk, self.settings.seeds, anywhere)
        more = {**with_prefix("method", method.policy()), **with_prefix("arrival", arrivals)}
        return {"q": self.q, "alpha": self.alpha, **more}

    def fixed(self) -> State:
        """How cells are numbered, and what is known of cells and automaton states."""
        return {
            "low": torch.from_numpy(self.cells.low),
            "sizes": torch.from_numpy(self.cells.sizes),
            "first_action": torch.tensor(self.first_action),
            "code": self.code,
            "floor": self.floor,
        }

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.q.copy_(state["q"])
        self.alpha.copy_(state["alpha"])
        self.method.load_policy(under("method", state))

    def rings(self) -> dict[str, Ring]:
        """What the algorithm keeps."""
        return with_prefix("method", self.method.rings())

    def rewards(self, observations: Floats) -> Tensor:
        """What the algorithm pays for s [n, d] in each automaton state b: [seed, b, n]."""
        seen = torch.from_numpy(observations)
        return rewards_of(self.method, seen, self.settings.seeds, self.walk.states)

    def state(self) -> State:
        """Everything that learning goes on from."""
        state = {
            **self.policy(),
            **with_prefix("method", self.method.state()),
            "generator": self.generator.get_state(),
            **with_prefix("recent", self.recent.state()),
            **with_prefix("closed", trails_state(self.closed)),
        }
        if self.shown is not None:
            state["leads"] = self.shown.leads
        return state

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.q.copy_(state["q"])
        self.alpha.copy_(state["alpha"])
        self.method.load(under("method", state))
        self.generator.set_state(state["generator"])
        self.recent.load(under("recent", state))
        self.closed = trails_of(under("closed", state))
        if self.shown is not None:
            self.shown.leads.copy_(state["leads"])

    def _learn(self, trail: Trail) -> Tensor:
        """Move Q towards the algorithm's target, turn by turn; the mean distance by seed."""
        if self.settings.relabel:
            trail = in_each_state(trail, self.live)
        options = self._options(trail.batch)
        turns = self._turns(trail, options, self.method.backup(trail.batch, options))
        entries, gaps = self.table.reshape(-1), np.zeros(len(turns.at), dtype=np.float32)
        for turn in turns:
            at = turns.at[turn]
            before = entries[at]
            target = turns.worth(turn, self._value(turns.after[turn]))
            gaps[turn] = self.settings.learning_rate * (target - before)
            entries[at] = before + gaps[turn]
            if self.tuned:
                self._tune(at // self.actions)
        seed, seeds = turns.at // (self.rows * self.actions), self.settings.seeds
        number = np.bincount(seed, minlength=seeds).clip(min=1)
        return torch.from_numpy(np.bincount(seed, np.abs(gaps), minlength=seeds) / number)

    def _options(self, batch: Batch) -> Tensor:
        """Where the automaton may be after each step, [seed, n, K]."""
        return torch.from_numpy(self.walk.options[batch.state.numpy(), batch.letter.numpy()])

    def _turns(self, trail: Trail, options: Tensor, backup: Backup) -> Turns:
        batch = trail.batch
        row = self._row(batch.observation.numpy(), batch.state.numpy())
        after = self._row(batch.next_observation.numpy(), options.numpy())
        at = row * self.actions + batch.action.numpy()
        return Turns.of(at, after, backup, trail.valid.numpy(), trail.age.numpy())

    def _row(self, observations: Floats, states: Int) -> Int:
        """The rows of the table of s [seed, n, d] and b [seed, n] or [seed, n, K]."""
        first = self.rows * np.arange(len(observations))[:, None]
        cell = first + self.walk.states * self.cells(observations)
        row: Int = cell.reshape(*cell.shape, *[1] * (states.ndim - 2)) + self.code.numpy()[states]
        return row

    def _value(self, row: Int) -> Floats:
        """V(s, b) of rows [...], no less than what demonstrations show."""
        q = self.table[row]
        value: Floats = q.max(-1)
        if self.soft:
            alpha = self.alpha.numpy()[row // self.rows]
            spread = np.exp((q - value[..., None]) / alpha.clip(min=1e-20)[..., None]).sum(-1)
            value = value + alpha * np.log(spread)
        if self.bounded:
            value = np.maximum(value, self.floor.numpy().reshape(-1)[row % self.rows])
        return value

    def _tune(self, row: Int) -> None:
        """Move each seed's α by how far π's entropy in these rows is from its target."""
        seeds = self.settings.seeds
        seed = row // self.rows
        q = self.table[row] / self.alpha.numpy()[seed][:, None]
        log_pi = q - q.max(-1, keepdims=True)
        log_pi -= np.log(np.exp(log_pi).sum(-1, keepdims=True))
        missing = self.settings.target_entropy + (np.exp(log_pi) * log_pi).sum(-1)
        number = np.bincount(seed, minlength=seeds).clip(min=1)
        gap = np.bincount(seed, missing, minlength=seeds) / number
        limit = 1 / (1 - self.settings.gamma)
        factor = torch.from_numpy(np.exp(self.settings.critic_rate * gap))
        self.alpha.mul_(factor).clamp_(LEAST_ALPHA, limit)

    def _demonstrated_values(self, shown: Shown) -> Tensor:
        """What demonstrated states are worth at least, [cell, automaton state].

        A demonstration shows that some action leads from each of its states to the next, whichever
        it is. Its return, with the least reward that could be learned, is a lower bound of the
        value where the environment is deterministic.
        """
        floor = torch.full((self.cells.count, self.walk.states), -torch.inf)
        if self.settings.demo_replay == 0 or not shown.lengths:
            return floor
        n = len(shown.state)
        kept = np.zeros((n, self.method.columns), dtype=np.float32)
        steps = shown_trail(shown, np.zeros(n, dtype=np.int64), kept, 1)
        in_turn = torch.arange(n - 1, -1, -1)[None]  # one demonstration adds to another's bounds
        trail = in_each_state(replace(steps, age=in_turn), self.live)
        options = self._options(trail.batch)
        least = self.method.least(trail.batch, options)
        if least is None:
            return floor
        bounds = floor.view(-1).numpy()
        turns = self._turns(trail, options, least)
        for turn in turns:
            row = turns.at[turn] // self.actions
            asked = turns.discount[turn] != 0  # what is exact does not ask for V, -inf or not
            worth = turns.worth(turn, np.where(asked, bounds[turns.after[turn]], 0.0))
            bounds[row] = np.maximum(bounds[row], worth)
        return floor
