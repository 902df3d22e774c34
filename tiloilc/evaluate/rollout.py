"""Episodes of a policy in environments of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tiloilc.learn import Labels, Policy
from tiloilc.plan import Plan
from tiloilc.product import Copies, Floats, Int, Product, walk_tables


@dataclass(frozen=True, slots=True, eq=False)
class Rollout:
    """What happened in each episode of each seed, the state after the reset included.

    An episode that its environment ends early stays where it ended, but accepts no more.

    observations  float32 [seed, T+1, d], of the first episode of each seed
    states        int [seed, episode, T+1], automaton states
    accepting     bool [seed, episode, T+1]
    sink          bool [seed, episode, T+1]
    """

    observations: Floats
    states: Int
    accepting: NDArray[np.bool_]
    sink: NDArray[np.bool_]


class Arena:
    """Environments for evaluation, apart from those of training, made once and used again."""

    def __init__(self, plan: Plan, labels: Labels, episodes: int) -> None:
        self.plan, self.labels, self.walk = plan, labels, walk_tables(plan.ldba)
        self.shape = (plan.train.seeds, episodes)
        self.copies = Copies(plan.environment, plan.train.seeds * episodes)

    def play(self, policy: Policy, episode_seeds: Sequence[int], greedy: bool = True) -> Rollout:
        """One episode for each entry of `episode_seeds`, the same ones for every seed."""
        seeds, episodes = self.shape
        assert len(episode_seeds) == episodes
        horizon, count = self.plan.environment.horizon, self.copies.count

        def choose(observations: Floats, options: Int) -> Int:
            by_seed = observations.reshape(*self.shape, -1), options.reshape(*self.shape, -1)
            return policy.choose(*by_seed, greedy).reshape(-1)

        product = Product(self.copies, self.labels, self.walk, choose)
        by_copy = np.array(list(episode_seeds) * seeds)
        product.reset(by_copy.tolist(), np.ones(count, dtype=np.bool_))
        shown = [product.observations]
        states, over = [product.states], [np.zeros(count, dtype=np.bool_)]
        ended = over[0]
        for t in range(horizon):
            seen = product.observations.reshape(*self.shape, -1)
            actions = policy.act(seen, product.states.reshape(self.shape), greedy)
            terminated = product.step(actions.reshape(count, *actions.shape[2:]))
            shown.append(np.where(ended[:, None], shown[-1], product.observations))
            states.append(np.where(ended, states[-1], product.states))
            over.append(ended)
            ended = ended | terminated
            if terminated.any() and t + 1 < horizon:  # nobody looks at what follows
                product.reset(by_copy.tolist(), terminated)
        path = np.stack(states, axis=1).reshape(*self.shape, horizon + 1)
        late = np.stack(over, axis=1).reshape(path.shape)
        observations = np.stack(shown, axis=1).reshape(*path.shape, -1)[:, 0]
        accepting = self.walk.accepting[path] & ~late
        return Rollout(observations, path, accepting, path == self.walk.sink)
