"""What the scripted expert of a task achieves in episodes, where no policy's maximum is known."""

from __future__ import annotations

import numpy as np

from tiloilc.demos import DemoSet, play, replay_all
from tiloilc.diag import CompileError
from tiloilc.evaluate.seeds import EVALUATION
from tiloilc.evaluate.verify.simulated import Trials
from tiloilc.learn import Labels
from tiloilc.plan import Plan


def expert_trials(plan: Plan, labels: Labels, expert: str, episodes: int) -> Trials:
    """The episodes of one expert as trials, [1, episode]: without noise, where that can be had.

    At ε-jumps they are read in their own favour. Raises CompileError DEMO506 or DEMO509 if there is
    no such expert.
    """
    made = plan.environment
    seeds = range(EVALUATION, EVALUATION + episodes)
    try:
        played = play(
            made.id, made.kwargs, horizon=made.horizon, expert=expert, seeds=seeds, noise=0.0
        )
    except CompileError as error:
        if all(diagnostic.code != "DEMO509" for diagnostic in error.diagnostics):
            raise
        played = play(made.id, made.kwargs, horizon=made.horizon, expert=expert, seeds=seeds)
    runs = replay_all(DemoSet(played), labels, plan.ldba)[1]
    violated = np.array([[run.violates_at is not None for run in runs]])
    visits = np.array([[run.visits for run in runs]])
    first = runs[0].states
    alike = all(np.array_equal(run.states, first) for run in runs)
    return Trials(violated, visits, np.array([alike]))
