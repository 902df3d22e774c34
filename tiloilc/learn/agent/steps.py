"""Steps of all copies at once, as tables learn them."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor

from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.state import State


@dataclass(frozen=True, slots=True)
class Steps:
    """One step of every copy, [seed, copy], and the automaton states b' in which it arrived.

    `valid` says which copies it belongs to. Actions are columns of the table.
    """

    batch: Batch
    valid: Tensor
    arrived: Tensor


def in_each_state(batch: Batch, states: Tensor) -> Batch:
    """Each step [seed, n] read from each of `states` [k] instead: [seed, n · k]."""
    k = len(states)
    parts = {f.name: repeated(getattr(batch, f.name), k) for f in fields(Batch)}
    seeds, n = batch.state.shape
    return Batch(**{**parts, "state": states.repeat(seeds, n)})


def repeated(rows: Tensor, times: int) -> Tensor:
    """Each of the rows [seed, n, …] so many times in turn, [seed, n · times, …]."""
    return rows.unsqueeze(2).expand(-1, -1, times, *rows.shape[2:]).flatten(1, 2)


def stacked(steps: list[Steps]) -> State:
    """Steps as one tensor for each of their parts."""
    if not steps:
        return {}
    names = [f.name for f in fields(Batch)]
    batch = {name: torch.stack([getattr(s.batch, name) for s in steps]) for name in names}
    rest = {name: torch.stack([getattr(s, name) for s in steps]) for name in ("valid", "arrived")}
    return {**batch, **rest}


def unstacked(state: State) -> list[Steps]:
    """The steps that `stacked` was given."""
    if not state:
        return []
    parts = [state[f.name].unbind() for f in fields(Batch)]
    batches = [Batch(*batch) for batch in zip(*parts, strict=True)]
    rest = (state["valid"].unbind(), state["arrived"].unbind())
    return [Steps(*step) for step in zip(batches, *rest, strict=True)]
