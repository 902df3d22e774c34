"""Where our update's time goes: `python -m tiloilc.bench.contestants.profile WORK`."""

from __future__ import annotations

import json
import re
import sys
from typing import Any

import torch._inductor.config as inductor
from torch.profiler import ProfilerActivity, profile

from tiloilc.bench.contestants.ours import updates
from tiloilc.bench.contestants.work import Work

UPDATES, WARM_UP = 100, 20
SHOWN = 14
LONGEST = 70


def _named(operation: str) -> str:
    """The name without what differs from one compilation to the next, cut where it gets long."""
    name = re.sub(r"CompiledFxGraph \w+", "CompiledFxGraph", operation)
    return name if len(name) <= LONGEST else name[: LONGEST - 1] + "…"


def main() -> None:
    """Print the operations that take most, as JSON [[operation, ms, calls], …] per update."""
    inductor.cpp.enable_kernel_profile = True  # else a compiled update is one operation
    run = updates(Work.from_json(sys.argv[1]))
    run(WARM_UP)
    with profile(activities=[ProfilerActivity.CPU]) as found:
        run(UPDATES)
    events: Any = found.key_averages()
    rows = [
        (_named(e.key), e.self_cpu_time_total / UPDATES / 1000, e.count / UPDATES) for e in events
    ]
    rows.sort(key=lambda row: -row[1])
    shown, others = rows[:SHOWN], rows[SHOWN:]
    rest = [("others", sum(row[1] for row in others), sum(row[2] for row in others))]
    sys.stdout.write(json.dumps([*shown, *rest]))


if __name__ == "__main__":
    main()
