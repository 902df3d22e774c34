"""The product of an environment and an automaton, many copies at once (paper, definition 2.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.product.environment import Copies, Floats
from tiloilc.product.walk import Int, Walk

Labels = Callable[[NDArray[np.float32]], Int]
Choice = Callable[[Floats, Int], Int]
"""Observations [n, d] and options [n, K] to the chosen automaton states [n]."""


class Product:
    """`n` copies of (s, b). Labels are of the state arrived in, the first one included.

    `observations` [n, d], `states` [n] and `elapsed` [n] (environment steps in the episode) are
    where the copies are now. ε-jumps cost no time: on each arrival `choose` picks one of the
    options that the automaton offers.
    """

    def __init__(self, copies: Copies, labels: Labels, walk: Walk, choose: Choice) -> None:
        self.copies, self.labels, self.walk, self.choose = copies, labels, walk, choose
        n = copies.count
        self.observations: Floats = np.zeros((n, copies.dimensions), dtype=np.float32)
        self.states: Int = np.full(n, walk.initial)
        self.letters: Int = np.zeros(n, dtype=np.int64)
        self.elapsed: Int = np.zeros(n, dtype=np.int64)

    def reset(self, seeds: Sequence[int], mask: NDArray[np.bool_]) -> None:
        """Begin episodes in the copies of `mask` and read the label of their first state."""
        observations = self.copies.reset(seeds, mask)
        self.observations = np.where(mask[:, None], observations, self.observations)
        letters = self.labels(observations)
        start = np.full_like(self.states, self.walk.initial)
        arrived = self._arrive(start, letters, observations)
        self.letters = np.where(mask, letters, self.letters)
        self.states = np.where(mask, arrived, self.states)
        self.elapsed = np.where(mask, 0, self.elapsed)

    def step(self, actions: NDArray[Any]) -> NDArray[np.bool_]:
        """Step all copies: s' from the environment, then b' = δ(b, L(s')) or by a jump.

        Returns who has terminated [n].
        """
        self.observations, terminated = self.copies.step(actions)
        self.letters = self.labels(self.observations)
        self.states = self._arrive(self.states, self.letters, self.observations)
        self.elapsed = self.elapsed + 1
        return terminated

    def _arrive(self, states: Int, letters: Int, observations: Floats) -> Int:
        options = self.walk.options[states, letters]
        if not self.walk.chooses:
            return options[:, 0]
        return self.choose(observations, options)
