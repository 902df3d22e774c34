"""What every engine is: it does jobs, somewhere, and tells what came of each."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.sweep.work import Outcome, Work


@dataclass(frozen=True)
class Started:
    """A job has begun, as far as the engine knows."""

    id: str


Event: TypeAlias = Started | Outcome | None
"""What an engine tells; None now and then, when there is nothing to tell."""


class Engine(Protocol):
    """Does jobs."""

    def results(self, works: Sequence[Work]) -> Generator[Event, None, None]:
        """Do all of them, begun in this order; one outcome for each, in any order.

        A job that fails is an outcome. Closing the generator, or an exception in it, ends what
        runs so that it can be gone on with.
        """
        ...


def unusable(engine: str, problem: object, help: str = "") -> CompileError:
    """RUN715: why there is no cluster to work on, in the first line of what it said."""
    line = next(iter(str(problem).strip().splitlines()), "no reason")
    return CompileError(Diagnostic.of("RUN715", engine=engine, problem=line, help=help))
