"""The memory of ten seeds when all their buffers are full, in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement, Spread
from tiloilc.bench.turns import ONE_THREAD, Tell

TASK = "flatworld_cycle"


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark; memory is measured once, since it does not vary."""
    command = [sys.executable, "-m", "tiloilc.bench.contestants.full", str(Work(TASK).path)]
    done = subprocess.run(command, env=os.environ | ONE_THREAD, stdout=subprocess.PIPE, check=True)
    found = json.loads(done.stdout)
    tell(f"{found['seeds']} seeds: {found['peak']:.0f} MiB")
    name = f"memory of {found['seeds']} seeds of {TASK}, buffers full"
    return [Measurement(name, Spread.of([found["peak"]]), "MiB")]
