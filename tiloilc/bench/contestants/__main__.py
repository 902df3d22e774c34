"""One contestant: `python -m tiloilc.bench.contestants MODULE FUNCTION WORK`.

Prints a line of JSON when it is ready, `{}` or `{"missing": package}`. Then, for each number read,
does so many pieces of its work and prints the seconds of processor time that took: on a core of its
own those are the clock's, and on one that others use, too, they are still its own. Work by threads
has all cores, and the clock's seconds.
"""

from __future__ import annotations

import json
import os
import sys
from importlib import import_module
from time import perf_counter, process_time

from tiloilc.bench.contestants.work import Run, Work

PACKAGES = {"stable_baselines3": "stable-baselines3", "sbx": "sbx-rl"}
"""What to install for a module that is missing, where the names differ."""


def main() -> None:
    """Take turns until there are no more."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # whatever libraries print is no answer
    module, function, told = sys.argv[1:]
    work = Work.from_json(told)
    clock = perf_counter if work.threads else process_time
    if not work.threads:
        _pin()
    try:
        for name in work.needs:
            import_module(name)
        make = getattr(import_module(f"tiloilc.bench.contestants.{module}"), function)
        run: Run = make(work)
    except ImportError as error:
        name = (error.name or "").partition(".")[0]
        answers.write(json.dumps({"missing": PACKAGES.get(name, name)}) + "\n")
        return
    answers.write("{}\n")
    for line in sys.stdin:
        began = clock()
        run(int(line))
        answers.write(f"{clock() - began}\n")


def _pin() -> None:
    """Stay on one core: the last one, on which fewest others are."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


if __name__ == "__main__":
    main()
