"""What one policy achieved, from the automaton states of its episodes (paper, appendix H.3).

An episode of T steps passes the automaton states b_0, b_1, …, b_T: b_0 is the state after the label
of the first environment state has been read, b_t the state that step t arrives in. Two conventions
follow, and every number below names which one it uses:

- *arrivals* b_1 … b_T are what the agent did. `accepting_visits`, `success` and `first_visit` count
  these, so no policy scores for where it was put, and T steps give at most T visits.
- Equation 17 sums over *all* states b_i, i ≥ 0. `eventual_return` therefore includes b_0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["METRICS", "EpisodeMetrics", "eventual_return", "first_visit", "measure"]

Bools: TypeAlias = npt.NDArray[np.bool_]
Floats: TypeAlias = npt.NDArray[np.float64]

METRICS = ("accepting_visits", "eventual_return", "violation_rate", "success", "first_visit")
"""The metrics of a policy in the order in which they are printed."""


@dataclass(frozen=True)
class EpisodeMetrics:
    """Means over episodes; every array has the leading axes of what was measured (one a seed).

    `first_visit` is in environment steps, the mean over the episodes that have a visit, and nan
    where none has. `violation_rate` and `success` are shares of episodes.
    """

    accepting_visits: Floats
    eventual_return: Floats
    violation_rate: Floats
    success: Floats
    first_visit: Floats

    def to_json(self) -> dict[str, list[float | None]]:
        """Lists by metric, in the order of the seeds; what is undefined (nan) becomes None."""
        columns = {name: np.atleast_1d(getattr(self, name)) for name in METRICS}
        return {
            name: [None if np.isnan(value) else float(value) for value in column]
            for name, column in columns.items()
        }


def measure(
    accepting: Bools, sink: Bools, *, gamma: float, start_accepting: Bools | None = None
) -> EpisodeMetrics:
    """The metrics of episodes given as arrays [..., episodes, T] over the arrivals b_1 … b_T.

    `accepting` and `sink` say what each arrival was. An episode that ended early is padded: not
    accepting, and sink where it ended in one. `start_accepting` [..., episodes] says whether b_0
    was accepting; None means it never was. A sink cannot be left, so b_0 needs no sink flag.
    """
    assert accepting.shape == sink.shape, f"{accepting.shape} and {sink.shape} differ"
    assert accepting.ndim >= 2, "one axis of episodes and one of steps"
    assert accepting.shape[-2] > 0, "a mean over no episodes"
    assert not (accepting & sink).any(), "a sink never accepts"
    if start_accepting is None:
        start_accepting = np.zeros(accepting.shape[:-1], dtype=np.bool_)
    assert start_accepting.shape == accepting.shape[:-1], "one start an episode"

    states = np.concatenate([start_accepting[..., None], accepting], axis=-1)
    first = first_visit(accepting)
    visited = ~np.isnan(first)
    visits_with = visited.sum(axis=-1)
    total_first = np.where(visited, first, 0.0).sum(axis=-1)
    return EpisodeMetrics(
        accepting_visits=accepting.sum(axis=-1).mean(axis=-1, dtype=np.float64),
        eventual_return=eventual_return(states, gamma).mean(axis=-1),
        violation_rate=sink.any(axis=-1).mean(axis=-1, dtype=np.float64),
        success=visited.mean(axis=-1, dtype=np.float64),
        first_visit=np.where(visits_with > 0, total_first / np.maximum(visits_with, 1), np.nan),
    )


def eventual_return(accepting: Bools, gamma: float) -> Floats:
    """Eq. 17 and 18 along the last axis: Σ_i Γ_i 1[b_i ∈ B*], Γ_i = Π_{t<i} (γ if b_t ∈ B* else 1).

    `accepting` [..., states] says of each b_i, from b_0 on, whether it is in B*. Time that passes
    outside B* costs nothing: the k-th visit (from 0) is worth γ^k whenever it comes.
    """
    assert 0.0 < gamma < 1.0, f"gamma {gamma} is not a discount"
    discount = np.where(accepting, gamma, 1.0)
    weight = np.ones(accepting.shape, dtype=np.float64)  # Γ_0 is the empty product
    np.cumprod(discount[..., :-1], axis=-1, out=weight[..., 1:])
    total: Floats = (weight * accepting).sum(axis=-1)
    return total


def first_visit(accepting: Bools) -> Floats:
    """The number of the step [...] that first arrives in B* (the first step is 1); nan if none.

    `accepting` [..., T] is over the arrivals b_1 … b_T.
    """
    ever = accepting.any(axis=-1)
    first: Floats = np.where(ever, accepting.argmax(axis=-1) + 1.0, np.nan)
    return first
