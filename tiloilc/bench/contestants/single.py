"""One environment from `gymnasium.make`, with neither labels nor automaton."""

from __future__ import annotations

import gymnasium

from tiloilc.bench.contestants.work import Run, Work
from tiloilc.driver import compile_spec


def steps(work: Work) -> Run:
    """Environment steps, actions given."""
    told = compile_spec(work.path).plan.environment
    world = gymnasium.make(told.id, max_episode_steps=told.horizon, **told.kwargs)
    world.action_space.seed(0)
    actions = [world.action_space.sample() for _ in range(told.horizon)]

    def run(times: int) -> None:
        for step in range(times):
            at = step % told.horizon
            if at == 0:
                world.reset(seed=0)
            world.step(actions[at])

    return run
