"""Steps as tables keep and learn them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.algorithm.method import Episode, Method
from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.product import Int


@dataclass(frozen=True, slots=True)
class Trail:
    """Steps [seed, n], of which the `valid` ones are learned, those of least `age` first.

    The age is how many steps came after it. Actions are columns of the table.
    """

    batch: Batch
    valid: Tensor
    age: Tensor


class Recent:
    """The last steps of every copy, [step, seed, copy, …]: as many as an episode has at most."""

    def __init__(self, horizon: int, columns: int) -> None:
        self.horizon, self.kept = horizon, columns
        self.rows: dict[str, NDArray[Any]] = {}
        self.taken = 0

    def add(self, *step: NDArray[Any]) -> None:
        """Keep one step of each copy: the columns of `_ROWS` in their order, [seed, copy, …]."""
        for name, column in zip(_ROWS, step, strict=True):
            if name not in self.rows:
                self.rows[name] = np.zeros((self.horizon, *column.shape), dtype=column.dtype)
            self.rows[name][self.taken % self.horizon] = column
        self.taken += 1

    def last(self, turn: int) -> Trail:
        """The latest step of one copy, each in its turn; what is kept of it is not known yet."""
        at = (self.taken - 1) % self.horizon
        seeds, copies = self.rows["state"][at].shape
        one = slice(turn % copies, turn % copies + 1)
        kept, never = torch.zeros(seeds, 1, self.kept), torch.zeros(seeds, 1, dtype=torch.bool)
        columns = [torch.from_numpy(self.rows[name][at, :, one]) for name in _ROWS[:-1]]
        parts = [*columns, kept, never]
        return Trail(Batch(*parts), ~never, never.long())

    def episodes(self, method: Method, over: NDArray[np.bool_], length: Int) -> Trail:
        """The episodes of the copies in `over`, of `length` steps; `method` judges them."""
        steps = int(length[over].max())
        at = np.arange(self.taken - steps, self.taken) % self.horizon
        *columns, arrived = (self.rows[name][at] for name in _ROWS)
        kept = np.zeros((steps, *over.shape, self.kept), dtype=np.float32)
        if self.kept:
            _, _, after, state, *_ = columns
            for seed, copy in np.argwhere(over):
                mine = slice(steps - int(length[seed, copy]), None), seed, copy
                kept[mine] = method.judge(Episode(after[mine], state[mine], arrived[mine]))
        age = np.arange(steps)[::-1, None, None]
        valid = over & (age < length)
        rows = (*columns, kept, np.zeros_like(valid), valid, np.broadcast_to(age, valid.shape))
        *batch, valid_ones, ages = (_by_seed(column) for column in rows)
        return Trail(Batch(*batch), valid_ones, ages)

    def state(self) -> State:
        """All of it."""
        rows = {name: torch.from_numpy(rows.copy()) for name, rows in self.rows.items()}
        return {**rows, "taken": torch.tensor(self.taken)}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.taken = int(state["taken"])
        self.rows = {name: state[name].numpy().copy() for name in _ROWS if name in state}


_ROWS = ("observation", "action", "after", "state", "letter", "terminal", "arrived")


def _by_seed(rows: NDArray[Any]) -> Tensor:
    """Rows [step, seed, copy, …] as [seed, step · copy, …]."""
    return torch.from_numpy(rows.swapaxes(0, 1).copy()).flatten(1, 2)


def ended(trails: Sequence[Trail]) -> Tensor:
    """The seeds [seed] that have a step to learn in one of the trails."""
    return torch.stack([trail.valid.any(1) for trail in trails]).any(0)


def in_each_state(trail: Trail, states: Tensor) -> Trail:
    """Each step [seed, n] read from each of `states` [k] instead: [seed, n · k]."""
    k, (seeds, n) = len(states), trail.age.shape
    parts = {f.name: _repeated(getattr(trail.batch, f.name), k) for f in fields(Batch)}
    batch = Batch(**{**parts, "state": torch.from_numpy(np.tile(states.numpy(), (seeds, n)))})
    return Trail(batch, _repeated(trail.valid, k), _repeated(trail.age, k))


def _repeated(rows: Tensor, times: int) -> Tensor:
    """Each of the rows [seed, n, …] so many times in turn, [seed, n · times, …]."""
    return torch.from_numpy(rows.numpy().repeat(times, axis=1))


def trails_state(trails: Sequence[Trail]) -> State:
    """Trails as tensors, by number."""
    parts: State = {}
    for number, trail in enumerate(trails):
        batch = {f.name: getattr(trail.batch, f.name) for f in fields(Batch)}
        parts |= with_prefix(str(number), {**batch, "valid": trail.valid, "age": trail.age})
    return parts


def trails_of(state: State) -> list[Trail]:
    """The trails that `trails_state` was given."""
    numbers = sorted({int(name.split(".")[0]) for name in state})
    each = [under(str(number), state) for number in numbers]
    return [
        Trail(Batch(*(parts[f.name] for f in fields(Batch))), parts["valid"], parts["age"])
        for parts in each
    ]
