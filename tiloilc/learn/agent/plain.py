"""Soft actor-critic on an environment's own rewards: the learner with all logic switched off.

What TiLoIL adds is measured against this, and this against other implementations: same networks,
same replay, same update, but a stored reward and one next state instead of an automaton.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.engine.replay import Replay
from tiloilc.learn.engine.sac import SoftActorCritic
from tiloilc.product import Floats
from tiloilc.spec.settings import Settings


class PlainSac:
    """Agents of all seeds; observations [seed, n, d] are taken as they are, actions in [−1, 1]."""

    def __init__(self, d: int, m: int, settings: Settings) -> None:
        self.settings = settings
        self.generator = torch.Generator().manual_seed(settings.first_seed)
        self.sac = SoftActorCritic(settings.seeds, d, m, settings, self.generator)
        self.parts = [d, m, 1, d, 1]
        capacity = min(settings.buffer_size, settings.steps)
        self.replay = Replay(settings.seeds, capacity, sum(self.parts))

    def act(self, observations: Floats, greedy: bool) -> Floats:
        """Actions in (−1, 1), [seed, n, m]."""
        x = torch.from_numpy(observations)
        action = self.sac.mean_action(x) if greedy else self.sac.sample(x).action
        return action.numpy()

    def record(
        self,
        observation: Floats,
        action: Floats,
        reward: NDArray[np.floating],
        after: Floats,
        terminal: NDArray[np.bool_],
    ) -> None:
        """Store transitions [seed, n, …]; `terminal` is an end of the task, not of the time."""
        columns = (observation, action, reward[..., None], after, terminal[..., None])
        self.replay.add(np.concatenate([c.astype(np.float32) for c in columns], axis=-1))

    def learn(self) -> dict[str, Tensor]:
        """One update from one batch; losses [seed] by name."""
        rows = self.replay.sample(self.settings.batch_size, self.generator)
        x, action, reward, after, terminal = rows.split(self.parts, dim=-1)
        value = self.sac.soft_value(after) * (1 - terminal[..., 0])
        target = reward[..., 0] + self.settings.gamma * value
        losses = {"critic": self.sac.update_critics(x, action, target)}
        losses["actor"] = self.sac.update_actor(x)
        self.sac.follow()
        return losses
