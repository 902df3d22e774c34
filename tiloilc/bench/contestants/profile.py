"""Where our update's time goes: `python -m tiloilc.bench.contestants.profile WORK`."""

from __future__ import annotations

import json
import sys
from typing import Any

from torch.profiler import ProfilerActivity, profile

from tiloilc.bench.contestants.ours import updates
from tiloilc.bench.contestants.work import Work

UPDATES, WARM_UP = 100, 20
SHOWN = 14


def main() -> None:
    """Print the operations that take most, as JSON [[operation, ms, calls], …] per update."""
    run = updates(Work.from_json(sys.argv[1]))
    run(WARM_UP)
    with profile(activities=[ProfilerActivity.CPU]) as found:
        run(UPDATES)
    events: Any = found.key_averages()
    rows = [(e.key, e.self_cpu_time_total / UPDATES / 1000, e.count / UPDATES) for e in events]
    rows.sort(key=lambda row: -row[1])
    shown, others = rows[:SHOWN], rows[SHOWN:]
    rest = [("others", sum(row[1] for row in others), sum(row[2] for row in others))]
    sys.stdout.write(json.dumps([*shown, *rest]))


if __name__ == "__main__":
    main()
