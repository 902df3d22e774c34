"""The best policy of each seed so far, by validation episodes."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from tiloilc.learn.engine.state import State, under, with_prefix


class Best:
    """Keeps, for each seed, the policy with the most accepting visits, then fewest violations."""

    def __init__(self, seeds: int) -> None:
        self.seeds = seeds
        self.scores = torch.full((seeds, 2), -torch.inf, dtype=torch.float64)
        self.policy: State = {}

    def offer(self, policy: State, visits: Sequence[float], violations: Sequence[float]) -> None:
        """Take over the seeds that are no worse than before; `policy` as an agent gives it."""
        scores = torch.tensor([visits, [-v for v in violations]], dtype=torch.float64).T
        more = scores[:, 0] > self.scores[:, 0]
        same = scores[:, 0] == self.scores[:, 0]
        better = more | (same & (scores[:, 1] >= self.scores[:, 1]))
        self.scores = torch.where(better[:, None], scores, self.scores)
        if not self.policy:
            self.policy = {name: tensor.to("cpu", copy=True) for name, tensor in policy.items()}
            return
        for name, tensor in policy.items():
            own = self.policy[name].view(self.seeds, -1)
            own[better] = tensor.reshape(self.seeds, -1).cpu()[better]

    def state(self) -> State:
        """The scores and the policy, for a checkpoint."""
        return {"scores": self.scores, **with_prefix("policy", self.policy)}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.scores = state["scores"]
        self.policy = under("policy", state)
