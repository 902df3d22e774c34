"""Episodes of a policy in environments of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.learn import Labels, Policy
from tiloilc.plan import Plan
from tiloilc.product import Copies, Floats, Int, Product, walk_tables
from tiloilc.spec import Environment


@dataclass(frozen=True, slots=True, eq=False)
class Rollout:
    """What happened in each episode of each seed, the state after the reset included.

    An episode that its environment ends early stays where it ended, but accepts no more.

    observations  float32 [seed, T+1, d], of the first episode of each seed
    states        int [seed, episode, T+1], automaton states
    accepting     bool [seed, episode, T+1]
    sink          bool [seed, episode, T+1]
    over          bool [seed, episode, T+1], after an early end
    """

    observations: Floats
    states: Int
    accepting: NDArray[np.bool_]
    sink: NDArray[np.bool_]
    over: NDArray[np.bool_]


class Arena:
    """Environments for evaluation, apart from those of training, made once and used again."""

    def __init__(
        self, plan: Plan, labels: Labels, episodes: int, copies: type[Copies] = Copies
    ) -> None:
        self.plan, self.labels = plan, labels
        self.walk = walk_tables(plan.ldba, plan.train.epsilon)
        self.shape = (plan.train.seeds, episodes)
        self.copies = copies(plan.environment, plan.train.seeds * episodes)

    def play(self, policy: Policy, episode_seeds: Sequence[int], greedy: bool = True) -> Rollout:
        """One episode for each entry of `episode_seeds`, the same ones for every seed.

        Or as many entries for each of the seeds, one seed's after those of another.
        """
        episodes = self.shape[1]
        horizon, count = self.plan.environment.horizon, self.copies.count
        assert len(episode_seeds) in (episodes, count)

        def choose(observations: Floats, options: Int) -> Int:
            by_seed = observations.reshape(*self.shape, -1), options.reshape(*self.shape, -1)
            return policy.choose(*by_seed, greedy).reshape(-1)

        product = Product(self.copies, self.labels, self.walk, choose, horizon)
        by_copy = np.array(list(episode_seeds) * (count // len(episode_seeds)))
        everyone = np.ones(count, dtype=np.bool_)
        product.reset(by_copy.tolist(), everyone)
        diary = _Diary(product, episodes, horizon)
        diary.note(everyone)
        playing = everyone
        for t in range(horizon):
            seen = product.observations.reshape(*self.shape, -1)
            actions = policy.act(seen, product.states.reshape(self.shape), greedy)
            terminated = product.step(actions.reshape(count, *actions.shape[2:]))
            diary.note(playing)
            playing = playing & ~terminated
            if terminated.any() and t + 1 < horizon:  # nobody looks at what follows
                product.reset(by_copy.tolist(), terminated)
        path, late = diary.path()
        path = path.reshape(*self.shape, horizon + 1)
        late = late.reshape(path.shape)
        accepting = self.walk.accepting[path] & ~late
        return Rollout(diary.observations(), path, accepting, path == self.walk.sink, late)


class EndlessCopies(Copies):
    """Copies that stay where their environment ends: their last label is read for ever.

    So a word is infinite whatever the environment does, as in the model that is verified exactly.
    """

    def __init__(self, environment: Environment, count: int) -> None:
        super().__init__(environment, count)
        self._seeds: Int = np.zeros(count, dtype=np.int64)
        self._last: Floats = np.zeros((count, self.dimensions), dtype=np.float32)
        self._stays = np.zeros(count, dtype=np.bool_)
        self._ended = np.zeros(count, dtype=np.bool_)

    def reset(self, seeds: Sequence[int], mask: NDArray[np.bool_]) -> Floats:
        """As of all copies."""
        self._seeds = np.where(mask, seeds, self._seeds)
        self._stays, self._ended = self._stays & ~mask, self._ended & ~mask
        observations = super().reset(self._seeds.tolist(), mask)
        self._last = np.where(self._stays[:, None], self._last, observations)
        return self._last.copy()

    def step(self, actions: NDArray[Any]) -> tuple[Floats, NDArray[np.bool_]]:
        """As of all copies, but that none ever ends."""
        if self._ended.any():  # an environment that ended takes no more steps, and nobody looks
            super().reset(self._seeds.tolist(), self._ended)
        observations, self._ended = super().step(actions)
        self._last = np.where(self._stays[:, None], self._last, observations)
        self._stays = self._stays | self._ended
        return self._last.copy(), np.zeros_like(self._ended)


class _Diary:
    """Where each copy of a product was after each step: its automaton states, and the observations
    of each seed's first episode."""

    def __init__(self, product: Product, episodes: int, horizon: int) -> None:
        self.product, self.episodes, self.horizon = product, episodes, horizon
        count, dimensions = product.observations.shape
        self.states: Int = np.zeros((count, horizon + 1), dtype=np.int64)
        self.seen: Floats = np.zeros((count // episodes, horizon + 1, dimensions), np.float32)
        self.last: Int = np.zeros(count, dtype=np.int64)

    def note(self, playing: NDArray[np.bool_]) -> None:
        """The copies of `playing` have arrived, and perhaps jumped in a step of its own."""
        product = self.product
        self._write(product.landed, product.elapsed - product.jumped, playing)
        self._write(product.states, product.elapsed, playing & product.jumped)

    def _write(self, states: Int, at: Int, who: NDArray[np.bool_]) -> None:
        rows = np.flatnonzero(who & (at <= self.horizon))
        self.states[rows, at[rows]] = states[rows]
        self.last[rows] = at[rows]
        first = rows[rows % self.episodes == 0]
        self.seen[first // self.episodes, at[first]] = self.product.observations[first]

    def path(self) -> tuple[Int, NDArray[np.bool_]]:
        """The states [n, T+1], each episode staying where it ended, and what came after its end."""
        times = np.arange(self.horizon + 1)
        late = times > self.last[:, None]
        return np.take_along_axis(self.states, np.minimum(times, self.last[:, None]), 1), late

    def observations(self) -> Floats:
        """The observations [seed, T+1, d] of the first episodes, staying where they ended."""
        times = np.minimum(np.arange(self.horizon + 1), self.last[:: self.episodes, None])
        return np.take_along_axis(self.seen, times[..., None], 1)
