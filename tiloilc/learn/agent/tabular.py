"""The agent on finite tasks: tabular soft Q-learning with the targets of an algorithm."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.agent.shown import Shown, judged_demonstrations
from tiloilc.learn.agent.shown_steps import ShownSteps
from tiloilc.learn.agent.steps import Steps, in_each_state, repeated, stacked, unstacked
from tiloilc.learn.algorithm.method import Episode, Setup, make_method, rewards_of
from tiloilc.learn.algorithm.tiloil import input_states
from tiloilc.learn.engine.cells import Cells
from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.ring import Ring
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
        self.options = torch.from_numpy(walk.options)
        self.floor = self._demonstrated_values(shown)
        bounded = bool(self.floor.isfinite().any())
        self.shown = None
        if settings.demo_replay > 0 and shown.lengths and not bounded:
            kept, numbers = (
                judged_demonstrations(self.method, shown),
                (settings.seeds, self.actions),
            )
            self.shown = ShownSteps(shown, kept, self.cells, *numbers, self.first_action)
        optimistic = not bounded if settings.optimistic == "auto" else settings.optimistic
        first = 1 / (1 - settings.gamma) if optimistic else 0.0
        shape = (settings.seeds, self.cells.count, walk.states, self.actions)
        self.q = torch.full(shape, first)
        self.seed = torch.arange(settings.seeds)[:, None]
        self.open: list[Steps] = []
        self.closed: list[Steps] = []

    def act(self, observations: Floats, states: Int, greedy: bool) -> Int:
        """The action of greatest value, ties at random; while learning sometimes any action."""
        values = self.q[self.seed, self.cells(torch.from_numpy(observations)), self.code[states]]
        if greedy:
            return values.argmax(-1).numpy() + self.first_action
        noise = torch.rand(values.shape, generator=self.generator)
        best = torch.where(values == values.amax(-1, keepdim=True), noise, -1.0).argmax(-1)
        if self.soft:  # the greatest Q + α · Gumbel is drawn from π
            gumbel = -(-noise.clamp(1e-9, 1 - 1e-7).log()).log()
            best = (values + self.alpha[:, None, None] * gumbel).argmax(-1)
        anything = torch.randint(self.actions, best.shape, generator=self.generator)
        stray = torch.rand(best.shape, generator=self.generator) < self.exploration
        return torch.where(stray, anything, best).numpy() + self.first_action

    def explore(self, rng: np.random.Generator, shape: tuple[int, int]) -> Int:
        """Uniformly random actions."""
        return rng.integers(self.actions, size=shape) + self.first_action

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        """The option of greatest value."""
        offered, seen = torch.from_numpy(options), torch.from_numpy(observations)
        value = self._value(self.cells(seen)[..., None], offered)
        value = self.method.worth(seen, offered, value)
        return offered.gather(-1, value.argmax(-1, keepdim=True)).squeeze(-1).numpy()

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
        columns = (observation, action - self.first_action, after, state, letter, terminal, arrived)
        *parts, to = (torch.from_numpy(np.ascontiguousarray(column)) for column in columns)
        everyone = torch.ones(state.shape, dtype=torch.bool)
        parts += [torch.zeros(*state.shape, self.method.columns), ~everyone]
        self.open.append(Steps(Batch(*parts), everyone, to))
        self.method.see(after, state, arrived)
        if self.shown is not None:
            self.shown.see(*parts[:3])

    def finish(self, over: NDArray[np.bool_], length: Int) -> None:
        """The episodes of the copies in `over` [seed, copy] ended after `length` steps."""
        ended = torch.from_numpy(over)
        if not over.any():
            return
        longest = int(length[over].max())
        steps = self.open[-longest:]
        if self.method.columns:
            self._judge(over, length)
        age = torch.from_numpy(length)
        self.closed += [
            replace(step, valid=ended & (age > k)) for k, step in enumerate(reversed(steps))
        ]
        running = int(length[~over].max(initial=0))
        self.open = self.open[len(self.open) - running :]

    def _judge(self, over: NDArray[np.bool_], length: Int) -> None:
        """Have the algorithm judge the episodes that ended."""
        for seed, copy in np.argwhere(over):
            steps = self.open[len(self.open) - int(length[seed, copy]) :]
            after = torch.stack([step.batch.next_observation[seed, copy] for step in steps])
            state = torch.stack([step.batch.state[seed, copy] for step in steps])
            arrived = torch.stack([step.arrived[seed, copy] for step in steps])
            kept = self.method.judge(Episode(after.numpy(), state.numpy(), arrived.numpy()))
            for step, row in zip(steps, torch.from_numpy(kept), strict=True):
                step.batch.kept[seed, copy] = row

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Take in a finished segment's states."""
        self.method.segment(seed, buffer, observations)

    def begin(self) -> bool:
        """Nothing is cloned; what was collected at random is learned with the next episode."""
        return False

    def learn(self, progress: float) -> dict[str, Tensor]:
        """Learn the latest step, or backwards the episodes that it ended; how far Q moved."""
        steps, losses = self.open[-1:], dict[str, Tensor]()
        if self.method.columns:  # what is open is not judged yet
            steps = []
        if self.closed:
            losses = self.method.learn(self.method.draw())
            steps, self.closed = self.closed, []
            steps += self.shown.backwards() if self.shown is not None else []
        moved = [self._learn_step(step) for step in steps]
        return {**losses, "change": torch.stack(moved).mean(0)} if moved else losses

    def policy(self) -> State:
        """What acting needs; each tensor's first axis counts seeds."""
        method = with_prefix("method", self.method.policy())
        return {"q": self.q, "alpha": self.alpha, **method}

    def fixed(self) -> State:
        """How cells are numbered, and what is known of cells and automaton states."""
        return {
            "low": self.cells.low,
            "sizes": self.cells.sizes,
            "first_action": torch.tensor(self.first_action),
            "code": self.code,
            "entry": self.method.known(),
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
            **with_prefix("open", stacked(self.open)),
            **with_prefix("closed", stacked(self.closed)),
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
        self.open = unstacked(under("open", state))
        self.closed = unstacked(under("closed", state))
        if self.shown is not None:
            self.shown.leads.copy_(state["leads"])

    def _learn_step(self, step: Steps) -> Tensor:
        """Move Q towards the algorithm's target for one step of each copy that has it."""
        s, batch, valid = self.settings, step.batch, step.valid
        if s.relabel:
            batch = in_each_state(batch, self.live)
            valid = repeated(valid, len(self.live))
        options = self.options[batch.state, batch.letter]
        value = self._value(self.cells(batch.next_observation)[..., None], options)
        target = self.method.target(batch, options, value)
        row = (self.seed, self.cells(batch.observation), self.code[batch.state])
        at = (*row, batch.action)
        gap = torch.where(valid, s.learning_rate * (target - self.q[at]), 0.0)
        if valid.all():
            self.q[at] += gap
        else:
            self.q[tuple(index.expand_as(valid)[valid] for index in at)] += gap[valid]
        if self.tuned:
            self._tune(self.q[row], valid)
        return gap.abs().view(*step.valid.shape, -1).mean(-1).sum(1)

    def _value(self, cell: Tensor, state: Tensor) -> Tensor:
        """V(s, b) [seed, n, K] of s [seed, n, 1] and b, no less than what demonstrations show."""
        arrived = self.code[state]
        q = self.q[self.seed[..., None], cell, arrived]
        if not self.soft:
            return q.amax(-1).maximum(self.floor[cell, arrived])
        alpha = self.alpha[:, None, None]
        soft = alpha * (q / alpha.clamp(min=1e-30)[..., None]).logsumexp(-1)
        return torch.where(alpha > 0, soft, q.amax(-1)).maximum(self.floor[cell, arrived])

    def _tune(self, q: Tensor, valid: Tensor) -> None:
        """Move each seed's α by how far π's entropy is from its target; q is [seed, n, A]."""
        log_pi = (q / self.alpha[:, None, None]).log_softmax(-1)
        missing = self.settings.target_entropy + (log_pi.exp() * log_pi).sum(-1)
        gap = (missing * valid).sum(1) / valid.sum(1).clamp(min=1)
        limit = 1 / (1 - self.settings.gamma)
        self.alpha.mul_((self.settings.critic_rate * gap).exp()).clamp_(1e-6, limit)

    def _demonstrated_values(self, shown: Shown) -> Tensor:
        """What demonstrated states are worth at least, [cell, automaton state].

        A demonstration shows that some action leads from each of its states to the next, whichever
        it is. Its return, with the least reward that could be learned, is a lower bound of the
        value where the environment is deterministic.
        """
        floor = torch.full((self.cells.count, self.walk.states), -torch.inf)
        if self.settings.demo_replay == 0:
            return floor
        none = torch.zeros(1, 1, dtype=torch.long)
        for t in reversed(range(len(shown.observation))):
            seen = torch.from_numpy(shown.observation[t])[None, None]
            after = torch.from_numpy(shown.next_observation[t])[None, None]
            letter = none + int(shown.letter[t])
            never, kept = none > 0, torch.zeros(1, 1, self.method.columns)
            batch = Batch(seen, none, after, none, letter, never, kept, ~never)
            batch = in_each_state(batch, self.live)
            options = self.options[batch.state, batch.letter]
            value = floor[self.cells(batch.next_observation)[..., None], self.code[options]]
            least = self.method.least(batch, options, value)
            if least is None:
                return floor
            at = (self.cells(batch.observation), self.code[batch.state])
            floor[at] = floor[at].maximum(least)
        return floor
