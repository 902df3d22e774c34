"""PWIL from states (Dadashi, Hussenot, Geist and Pietquin, ICLR 2021).

Faithful: the greedy coupling of an episode's states with those of demonstrations, and the reward
α exp(−βT/√d · cost) with α = β = 5. It depends on all that came before in the episode, so it is
kept beside the step and never computed again. Reconstructed: states only, where the original takes
actions as well; steps are learned when their episode is over, for the rewards of all its steps are
computed then.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.algorithm.arrivals import Arrivals
from tiloilc.learn.algorithm.method import Episode, Setup
from tiloilc.learn.engine.replay import Batch
from tiloilc.product import Floats

SCALE, RATE = 5.0, 5.0
"""α and β of the original, the same for all its tasks."""


class PWIL(Arrivals):
    """A step is paid by how cheaply its state can be moved onto demonstrated ones."""

    doomed = False

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        shown = setup.demonstrations.cpu().numpy().astype(np.float64)
        self.horizon = setup.horizon
        self.middle = shown.mean(0) if len(shown) else np.zeros(shown.shape[1])
        spread = shown.std(0) if len(shown) else np.ones(shown.shape[1])
        self.spread = np.where(spread > 1e-6, spread, 1.0)
        self.atoms = (shown - self.middle) / self.spread

    @property
    def columns(self) -> int:
        """The reward."""
        return 1

    def judge(self, episode: Episode) -> Floats:
        """The reward of each step."""
        states = (episode.after - self.middle) / self.spread
        cost = coupling_costs(states, self.atoms, self.horizon)
        rate = RATE * self.horizon / np.sqrt(states.shape[1])
        reward: Floats = (SCALE * np.exp(-rate * cost)).astype(np.float32)
        return reward[:, None]

    def extra(self, batch: Batch, options: Tensor) -> Tensor:
        """The reward that was kept."""
        return batch.kept


def coupling_costs(
    states: NDArray[np.float64], atoms: NDArray[np.float64], horizon: int
) -> NDArray[np.float64]:
    """What it costs to move each state of an episode onto `atoms` [n, d], greedily; [m].

    Each of at most `horizon` states [m, d] carries the mass 1 / horizon, each atom takes 1 / n. One
    state after the other moves to the nearest atoms that still have room (algorithm 1 there).
    """
    room = np.full(len(atoms), 1 / max(len(atoms), 1))
    costs = np.zeros(len(states))
    for t, state in enumerate(states):
        distance = np.linalg.norm(atoms - state, axis=1)
        nearest = np.argsort(distance, kind="stable")
        offered = room[nearest]
        before = offered.cumsum() - offered
        moved = np.clip(1 / horizon - before, 0, offered)
        room[nearest] -= moved
        costs[t] = moved @ distance[nearest]
    return costs
