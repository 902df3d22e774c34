"""Steps as numbers of rows and entries of a table, so that learning them is arithmetic alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tiloilc.learn.algorithm.method import Backup
from tiloilc.product import Floats, Int


@dataclass(frozen=True, slots=True)
class Turns:
    """m steps in the order in which they are learned, and where each turn of them ends.

    Those of one turn are learned at once. `at` [m] is the entry that each moves, `after` [m, K] the
    rows of (s', b') by option, `pay` and `discount` [m, K] what a `Backup` says of them.
    """

    at: Int
    after: Int
    pay: Floats
    discount: Floats
    ends: tuple[int, ...]

    @classmethod
    def of(cls, at: Int, after: Int, backup: Backup, valid: NDArray[np.bool_], age: Int) -> Turns:
        """The `valid` ones of the steps [seed, n], those of an age together, youngest first."""
        chosen = np.flatnonzero(valid)
        ages = age.reshape(-1)[chosen]
        order = ages.argsort(kind="stable")
        chosen, ages = chosen[order], ages[order]
        k = after.shape[-1]
        pay, discount = (
            np.broadcast_to(part.numpy(), after.shape).reshape(-1, k)[chosen]
            for part in (backup.pay, backup.discount)
        )
        ends = (*(np.flatnonzero(ages[1:] > ages[:-1]) + 1).tolist(), len(chosen))
        return cls(at.reshape(-1)[chosen], after.reshape(-1, k)[chosen], pay, discount, ends)

    def __iter__(self) -> Iterator[slice]:
        """One turn after the other."""
        first = 0
        for end in self.ends:
            yield slice(first, end)
            first = end

    def worth(self, turn: slice, value: Floats) -> Floats:
        """What the steps of `turn` are worth, [m], given V of what comes after them, [m, K]."""
        worth: Floats = (self.pay[turn] + self.discount[turn] * value).max(-1)
        return worth
