"""Collecting and learning: Algorithm 1 of the paper, for all seeds in one program."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.agent.protocol import Agent
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.learn.run.tally import Tally
from tiloilc.product import Copies, Floats, Int, Product, Segment, Segmenter, Walk
from tiloilc.spec.settings import Settings


class Loop:
    """The state of one training run between two environment steps.

    `cloned` says whether this program began learning with a policy cloned from demonstrations.
    """

    def __init__(
        self,
        settings: Settings,
        horizon: int,
        walk: Walk,
        copies: Copies,
        labels: Callable[[Floats], Int],
        agent: Agent,
        segmenter: Segmenter,
    ) -> None:
        self.settings, self.horizon, self.walk, self.agent = settings, horizon, walk, agent
        self.shape = (settings.seeds, copies.count // settings.seeds)
        self.product = Product(copies, labels, walk, self._choose, horizon)
        self.segmenter = segmenter
        self.rng = np.random.default_rng([settings.first_seed, settings.seeds])
        self.step = 0
        self.debt = 0.0
        self.cloned = False
        self.episodes: Int = np.zeros(copies.count, dtype=np.int64)
        self.actions: NDArray[Any] | None = None
        self.tally = Tally.empty(settings.seeds, walk.states)

    @property
    def exploring(self) -> bool:
        """Whether actions are still random."""
        return self.step < self.settings.learning_starts

    def run(self, until: int) -> Iterator[int]:
        """Collect and learn up to environment step `until` (per seed); yields after each step."""
        if self.step == 0:
            self._reset(np.ones(self.product.copies.count, dtype=np.bool_))
            if not self.exploring:
                self.cloned = self.agent.begin()
        while self.step < until:
            exploring, before = self.exploring, self.step
            self._collect()
            if not exploring:
                self._infer(before)
                self._learn()
            elif not self.exploring:
                self.cloned = self.agent.begin()
            yield self.step

    def _collect(self) -> None:
        product, agent = self.product, self.agent
        observations, states = product.observations, product.states
        if self.exploring:
            actions = agent.explore(self.rng, self.shape)
        else:
            actions = agent.act(self._by_seed(observations), self._by_seed(states), greedy=False)
        flat = actions.reshape(product.copies.count, *actions.shape[2:])
        self._remember(flat)
        terminal = product.step(flat)
        agent.record(
            self._by_seed(observations),
            actions,
            self._by_seed(product.observations),
            self._by_seed(states),
            self._by_seed(product.letters),
            self._by_seed(terminal),
            self._by_seed(product.states),
        )
        everyone = np.ones(product.copies.count, dtype=np.bool_)
        self._arrive(everyone)
        in_sink = product.states == self.walk.sink
        over = terminal | (product.elapsed >= self.horizon)
        if self.settings.end_on_sink:
            over |= in_sink
        self._count(over, in_sink)
        if over.any():
            agent.finish(self._by_seed(over), self._by_seed(product.moves))
            self._store(self.segmenter.end(over))
            self._reset(over)
        self.step += self.shape[1]

    def _infer(self, before: int) -> None:
        """Have the demonstrations' actions inferred again whenever there are enough more steps."""
        first, growth = self.settings.learning_starts, self.settings.inference_growth
        if growth == 1 or first == 0:
            return
        if _times(before / first, growth) < _times(self.step / first, growth):
            self.agent.infer(self.step - first < self.settings.warm_start_steps)

    def _learn(self) -> None:
        self.debt += self.settings.updates_per_step * self.shape[1]
        while self.debt >= 1:
            self.debt -= 1
            losses = self.agent.learn(self.step - self.settings.learning_starts)
            self.tally.add_losses(losses)

    def _store(self, segments: list[Segment]) -> None:
        for s in segments:
            self.agent.segment(s.copy // self.shape[1], s.buffer, s.observations)

    def _reset(self, mask: NDArray[np.bool_]) -> None:
        """Begin new episodes, each with a seed of its own: that of agent, copy and episode."""
        self.product.reset(self._seeds(self.episodes, mask), mask)
        self.episodes = self.episodes + mask
        visited = self.product.jumped & self.walk.accepting[self.product.states]
        self.tally.visits += self._by_seed(visited).sum(1)  # a jump is an arrival, a start is none
        self._arrive(mask)

    def _arrive(self, mask: NDArray[np.bool_]) -> None:
        """Collect where the copies of `mask` are now, and where they were before a jump."""
        product, collector = self.product, self.segmenter
        self._store(collector.arrive(product.observations, product.landed, mask))
        if self.walk.costly:
            self._store(collector.arrive(product.observations, product.states, product.jumped))

    def _count(self, over: NDArray[np.bool_], in_sink: NDArray[np.bool_]) -> None:
        tally, states = self.tally, self._by_seed(self.product.states)
        tally.visits += self.walk.accepting[states].sum(1)
        tally.episodes += self._by_seed(over).sum(1)
        tally.violations += self._by_seed(over & in_sink).sum(1)
        np.add.at(tally.occupancy, (np.arange(self.shape[0])[:, None], states), 1)

    def _remember(self, actions: NDArray[Any]) -> None:
        """Keep the actions of unfinished episodes: resuming plays them again."""
        if self.actions is None:
            shape = (len(actions), self.horizon, *actions.shape[1:])
            self.actions = np.zeros(shape, dtype=actions.dtype)
        self.actions[np.arange(len(actions)), self.product.moves] = actions

    def _choose(self, observations: Floats, options: Int) -> Int:
        chosen = self.agent.choose(
            self._by_seed(observations), self._by_seed(options), greedy=False
        )
        return chosen.reshape(-1)

    def _by_seed(self, array: NDArray[Any]) -> NDArray[Any]:
        return array.reshape(*self.shape, *array.shape[1:])

    def state(self) -> State:
        """Everything between two steps; the environments are brought back by `load`."""
        product, actions = self.product, self.actions
        assert actions is not None, "a run begins with a step"
        arrays: dict[str, NDArray[Any]] = {
            "observations": product.observations,
            "states": product.states,
            "letters": product.letters,
            "elapsed": product.elapsed,
            "moves": product.moves,
            "episodes": self.episodes,
            "actions": actions,
            "step": np.array(self.step),
            "debt": np.array(self.debt),
            "rng": np.frombuffer(json.dumps(self.rng.bit_generator.state).encode(), np.uint8),
        }
        arrays |= {f"segments.{name}": array for name, array in self.segmenter.state().items()}
        return {
            **{name: torch.from_numpy(array.copy()) for name, array in arrays.items()},
            **with_prefix("tally", self.tally.state()),
            **with_prefix("agent", self.agent.state()),
        }

    def load(self, state: State) -> None:
        """Go on from what `state` gave: unfinished episodes are played again, action by action."""
        arrays = {name: tensor.numpy() for name, tensor in state.items()}
        self.agent.load(under("agent", state))
        self.tally = Tally.of(under("tally", state))
        self.segmenter.load({n[9:]: a for n, a in arrays.items() if n.startswith("segments.")})
        self.rng.bit_generator.state = json.loads(arrays["rng"].tobytes())
        self.step, self.debt = int(arrays["step"]), float(arrays["debt"])
        self.episodes, self.actions = arrays["episodes"], arrays["actions"]
        product = self.product
        product.observations, product.states = arrays["observations"], arrays["states"]
        product.letters, product.moves = arrays["letters"], arrays["moves"]
        product.elapsed = arrays["elapsed"]
        self._replay()

    def _replay(self) -> None:
        """Bring the environments to where they were: begin each episode late enough and act.

        Copies that wait for their time are reset again and again, so that none is stepped past an
        end. Raises CompileError RUN705 if an environment does not repeat itself.
        """
        product = self.product
        moves, longest = product.moves, int(product.moves.max())
        seeds = self._seeds(self.episodes - 1, np.ones(product.copies.count, np.bool_))
        rows = np.arange(product.copies.count)
        assert self.actions is not None
        observations = product.observations
        for k in range(longest + 1):
            waiting = moves <= longest - k
            if waiting.any():
                observations = product.copies.reset(seeds, waiting)
            if k < longest:
                played = np.maximum(k - (longest - moves), 0)
                observations, _ = product.copies.step(self.actions[rows, played])
        if not np.array_equal(observations, product.observations):
            raise CompileError(Diagnostic.of("RUN705"))

    def _seeds(self, episodes: Int, mask: NDArray[np.bool_]) -> list[int]:
        """A seed for the episode of each copy of `mask`: by agent, copy and number; else 0."""
        first, copies = self.settings.first_seed, self.shape[1]
        seeds = [0] * len(episodes)
        for i in np.flatnonzero(mask).tolist():
            entropy = [first + i // copies, i % copies, int(episodes[i])]
            seeds[i] = int(np.random.SeedSequence(entropy).generate_state(1)[0])
        return seeds


def _times(grown: float, growth: float) -> int:
    """How many whole factors `growth` are in `grown`."""
    return math.floor(math.log(grown) / math.log(growth))
