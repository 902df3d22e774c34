"""The memory of ten seeds when all their buffers are full, in a process of its own."""

from __future__ import annotations

import json

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement, Spread
from tiloilc.bench.turns import Tell, ask

WORK = Work("flatworld_cycle")


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark; memory is measured once, since it does not vary."""
    found = json.loads(ask("full", WORK))
    tell(f"{found['seeds']} seeds: {found['peak']:.0f} MiB")
    name = f"memory of {found['seeds']} seeds of {WORK.task}, buffers full"
    return [Measurement(name, Spread.of([found["peak"]]), "MiB")]
