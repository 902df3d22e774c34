"""A run with full buffers, and its memory: `python -m tiloilc.bench.contestants.full WORK`."""

from __future__ import annotations

import dataclasses
import json
import sys

import numpy as np

from tiloilc.bench.automata.alone import peak_memory
from tiloilc.bench.contestants.work import Work
from tiloilc.driver import compile_spec, labeller
from tiloilc.learn.run.job import make_loop

CHUNK = 10_000
"""Transitions that are stored at once."""


def main() -> None:
    """Print seeds and peak memory in MiB as one JSON object."""
    work = Work.from_json(sys.argv[1])
    compiled = compile_spec(work.path)
    settings = compiled.plan.train
    settings = settings.override(
        {"steps": settings.buffer_size, "compile": "always" if work.compiled else "never"}
    )
    plan = dataclasses.replace(compiled.plan, train=settings)
    loop = make_loop(plan, compiled.demos, labeller(plan))
    for _ in loop.run(settings.learning_starts + 1):
        pass
    agent, d = loop.agent, loop.product.copies.dimensions
    shape = (settings.seeds, CHUNK)
    actions = agent.explore(np.random.default_rng(0), shape)
    seen, zeros = np.zeros((*shape, d), np.float32), np.zeros(shape, np.int64)
    for _ in range(settings.buffer_size // CHUNK):
        agent.record(seen, actions, seen, zeros, zeros, zeros > 0, zeros)
    many = np.zeros((settings.stage_buffer_size, d), np.float32)
    for seed in range(settings.seeds):
        for buffer in range(plan.stages.sink_buffer + 1):
            agent.segment(seed, buffer, many)
    agent.learn(0)
    sys.stdout.write(json.dumps({"seeds": settings.seeds, "peak": peak_memory()}))


if __name__ == "__main__":
    main()
