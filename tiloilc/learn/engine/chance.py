"""The random part of an update, drawn before it: the rest is a function that can be compiled."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from tiloilc.learn.engine.state import State

RELABELLED = 0.5
"""How many steps of a batch are read from an automaton state drawn at random, with `relabel`."""


@dataclass(frozen=True, slots=True)
class Chance:
    """What one update needs of chance.

    Places in the replay [seed, n − n'] and among the demonstrations [seed, n', 1]; automaton states
    from which steps are read instead [seed, n], -1 for their own; noise of the actions of each
    option and of each state [seed, n·(K + 1), m]; and what the algorithm draws.
    """

    rows: Tensor
    shown: Tensor | None
    state: Tensor | None
    noise: Tensor
    method: State


def draw_shown(rows: Tensor | None, count: int, generator: torch.Generator) -> Tensor | None:
    """Places of `count` demonstrated steps among `rows` [seed, m, width]; None without any."""
    if rows is None or count == 0:
        return None
    shape = (rows.shape[0], count, 1)
    return torch.randint(rows.shape[1], shape, generator=generator, device=generator.device)


def draw_states(
    live: Tensor, shape: tuple[int, int], shown: int, generator: torch.Generator
) -> Tensor:
    """For RELABELLED of the steps [seed, n] a `live` state to read them from, -1 for the others.

    The first `shown` steps, which are demonstrations', stay what they are.
    """
    device = generator.device
    drawn = live[torch.randint(len(live), shape, generator=generator, device=device)]
    kept = torch.rand(shape, generator=generator, device=device) >= RELABELLED
    kept[:, :shown] = True
    return drawn.masked_fill(kept, -1)
