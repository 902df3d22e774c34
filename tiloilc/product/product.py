"""The product of an environment and an automaton, many copies at once (paper, definition 2.3)."""

from __future__ import annotations

import math
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

    `observations` [n, d], `states` [n] and `elapsed` [n] (steps in the episode) are where the
    copies are now. On each arrival `choose` picks one of the options that the automaton offers.
    That costs no time, unless the walk's jumps are `costly`: then a jump is a step of its own, in
    which the environment stands still and no label is read (definition 2.3). Of the latest arrival,
    `landed` [n] are the automaton states before such a jump and `jumped` [n] says who took one;
    `moves` [n] counts the environment's steps alone. After `horizon` steps nobody jumps.
    """

    def __init__(
        self,
        copies: Copies,
        labels: Labels,
        walk: Walk,
        choose: Choice,
        horizon: float = math.inf,
    ) -> None:
        self.copies, self.labels, self.walk, self.choose = copies, labels, walk, choose
        self.horizon = horizon
        n = copies.count
        self.observations: Floats = np.zeros((n, copies.dimensions), dtype=np.float32)
        self.states: Int = np.full(n, walk.initial)
        self.landed: Int = self.states
        self.jumped = np.zeros(n, dtype=np.bool_)
        self.letters: Int = np.zeros(n, dtype=np.int64)
        self.elapsed: Int = np.zeros(n, dtype=np.int64)
        self.moves: Int = np.zeros(n, dtype=np.int64)

    def reset(self, seeds: Sequence[int], mask: NDArray[np.bool_]) -> None:
        """Begin episodes in the copies of `mask` and read the label of their first state."""
        observations = self.copies.reset(seeds, mask)
        self.observations = np.where(mask[:, None], observations, self.observations)
        self.letters = np.where(mask, self.labels(observations), self.letters)
        self.elapsed = np.where(mask, 0, self.elapsed)
        self.moves = np.where(mask, 0, self.moves)
        self._arrive(np.full_like(self.states, self.walk.initial), mask, mask)

    def step(self, actions: NDArray[Any]) -> NDArray[np.bool_]:
        """Step all copies: s' from the environment, then b' = δ(b, L(s')) or by a jump.

        Returns who has terminated [n].
        """
        self.observations, terminated = self.copies.step(actions)
        self.letters = self.labels(self.observations)
        self.elapsed = self.elapsed + 1
        self.moves = self.moves + 1
        self._arrive(self.states, np.ones_like(terminated), ~terminated)
        return terminated

    def _arrive(self, states: Int, mask: NDArray[np.bool_], alive: NDArray[np.bool_]) -> None:
        """The copies of `mask` read their letters in `states`; those `alive` may go on to jump."""
        options = self.walk.options[states, self.letters]
        first = options[:, 0]
        chosen = self.choose(self.observations, options) if self.walk.chooses else first
        if not self.walk.costly:
            self.states = self.landed = np.where(mask, chosen, self.states)
            return
        chosen = np.where(alive & (self.elapsed < self.horizon), chosen, first)
        self.states = np.where(mask, chosen, self.states)
        self.landed = np.where(mask, first, self.states)
        self.jumped = self.landed != self.states
        self.elapsed = self.elapsed + self.jumped
