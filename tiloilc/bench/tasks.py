"""How long ten seeds train, with the settings of the task file, until they are near the optimum."""

from __future__ import annotations

import json

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement, Spread
from tiloilc.bench.turns import Tell, ask

TASKS = {"flatworld_cycle": 300.0, "grid_circular_hard": 20.0}
"""Each with the most seconds it may take."""


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark; a run to the optimum is long, so there is one."""
    rows = []
    for task, goal in TASKS.items():
        found = json.loads(ask("optimum", Work(task)))
        name = f"{task}, {found['seeds']} seeds to {found['wanted']:.3g} visits"
        reached = found["seconds"]
        tell(f"{name}: {'never' if reached is None else f'{reached:.0f} s'}")
        seconds = None if reached is None else Spread.of([reached])
        rows.append(Measurement(name, seconds, "s", goal=goal))
    return rows
