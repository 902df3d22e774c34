"""What the training loop asks of a learner, continuous or tabular."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State
from tiloilc.product import Floats, Int


class Policy(Protocol):
    """What acts. Arrays are [seed, copy, …]."""

    def act(self, observations: Floats, states: Int, greedy: bool) -> NDArray[Any]:
        """Actions for s [seed, copy, d] and b [seed, copy]; greedy ones use no randomness."""

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        """One of the automaton states in `options` [seed, copy, K], for each copy."""

    def policy(self) -> State:
        """What is learned of acting; the first axis of each tensor is a multiple of the seeds."""

    def fixed(self) -> State:
        """What else acting needs: the same for all seeds, and from beginning to end."""

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""


class Agent(Policy, Protocol):
    """What the loop asks of a learner."""

    def explore(self, rng: np.random.Generator, shape: tuple[int, int]) -> NDArray[Any]:
        """Random actions for [seed, copy]."""

    def record(
        self,
        observation: Floats,
        action: NDArray[Any],
        after: Floats,
        state: Int,
        letter: Int,
        terminal: NDArray[np.bool_],
        arrived: Int,
    ) -> None:
        """Take in one step of each copy: (s, b), a, s', the letter of s', and b'."""

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Take in a finished segment's states [m, d] for a stage buffer."""

    def finish(self, over: NDArray[np.bool_], length: Int) -> None:
        """The episodes of the copies in `over` have ended after `length` steps."""

    def begin(self) -> bool:
        """The random steps are over; whether a policy was cloned from demonstrations."""

    def infer(self, cloning: bool) -> None:
        """The agent has many more steps by now: infer the demonstrations' actions again, and clone
        them again if `cloning`.
        """

    def learn(self, progress: float) -> dict[str, Tensor]:
        """One update, `progress` environment steps into learning; losses [seed] by name."""

    def rings(self) -> dict[str, Ring]:
        """What is too large to be saved whole each time, by name; `load` comes before its rows."""

    def rewards(self, observations: Floats) -> Tensor:
        """Eq. 8 of s [n, d] in each automaton state b, by today's discriminators: [seed, b, n]."""

    def state(self) -> State:
        """Everything else that learning goes on from."""

    def load(self, state: State) -> None:
        """Take what `state` gave."""
