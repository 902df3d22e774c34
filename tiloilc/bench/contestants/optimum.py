"""Trains until the seeds are near the optimum: `python -m tiloilc.bench.contestants.optimum WORK`.

That is when a run that stopped would leave policies whose mean accepting visits are nine tenths of
what is possible: each seed's best so far, greedily, on the episodes by which policies are chosen.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory
from time import perf_counter

from tiloilc.bench.contestants.work import Work
from tiloilc.driver import compile_spec, labeller
from tiloilc.evaluate.protocol import Validator, task_optimum_of
from tiloilc.learn import Watched, train

SHARE = 0.9
"""The same for all tasks (protocol: sample efficiency)."""


class _Reached(Exception):
    """Nothing more to learn."""


def main() -> None:
    """Print the seeds, the visits wanted and the seconds until then, null if never, as JSON."""
    compiled = compile_spec(Work.from_json(sys.argv[1]).path)
    plan, labels = compiled.plan, labeller(compiled.plan)
    optimum = task_optimum_of(plan, labels)
    assert optimum is not None, "these tasks have a finite model"
    wanted = SHARE * float(optimum.accepting_visits)
    validator = Validator(plan, labels)
    seconds = None
    best = [0.0] * plan.train.seeds
    began = perf_counter()

    def watch(watched: Watched) -> None:
        if watched.metrics is not None:
            visits = [value or 0.0 for value in watched.metrics["accepting_visits"]]
            best[:] = map(max, best, visits)
            if mean(best) >= wanted:
                raise _Reached

    with TemporaryDirectory() as folder:
        try:
            train(plan, compiled.demos, labels, Path(folder), validator, watch, {})
        except _Reached:
            seconds = perf_counter() - began
    answer = {"seeds": plan.train.seeds, "wanted": wanted, "seconds": seconds}
    sys.stdout.write(json.dumps(answer))


if __name__ == "__main__":
    main()
