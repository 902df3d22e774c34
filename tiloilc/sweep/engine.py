"""What every engine is: it does jobs, somewhere, and tells what came of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from tiloilc.sweep.work import Outcome, Work


@dataclass(frozen=True)
class Started:
    """A job has begun, as far as the engine knows."""

    id: str


Event: TypeAlias = Started | Outcome | None
"""What an engine tells; None now and then, when there is nothing to tell."""


class Engine(Protocol):
    """Does jobs."""

    def results(self, works: Sequence[Work]) -> Iterator[Event]:
        """Do all of them, begun in this order; one outcome for each, in any order.

        A job that fails is an outcome. Closing the iterator, or an exception in it, ends what
        runs so that it can be gone on with.
        """
        ...
