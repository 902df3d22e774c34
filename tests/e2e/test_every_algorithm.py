"""Every algorithm on every task: compiled, trained for 2,000 steps, evaluated."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tiloilc.driver import Compiled, compile_spec, labeller
from tiloilc.evaluate.protocol import Validator, evaluate_run
from tiloilc.learn import train
from tiloilc.plan import importable
from tiloilc.spec.model import Evaluate
from tiloilc.spec.settings import ALGORITHMS

SPECS = sorted(Path(__file__).parents[2].glob("specs/*.yaml"))

SHORT = {"steps": 2000, "seeds": 1, "learning_starts": 1000, "updates_per_step": 0.2}


def test_no_task_is_missing() -> None:
    assert len(SPECS) == 22  # SixteenRooms has two formulas


@pytest.mark.slow
@pytest.mark.parametrize("spec", SPECS, ids=lambda path: path.stem)
def test_every_algorithm_trains_and_is_evaluated(spec: Path, tmp_path: Path) -> None:
    task = compile_spec(spec)
    for algorithm in sorted({*ALGORITHMS} - {"cloning"}):
        run = tmp_path / algorithm
        run.mkdir()
        judged = trained(task, algorithm, run)
        for policy in ("greedy", "stochastic", "last"):
            (visits,) = judged[policy]["accepting_visits"]
            assert 0 <= visits <= task.plan.environment.horizon, (algorithm, policy)


def trained(task: Compiled, algorithm: str, run: Path) -> Mapping[str, Any]:
    """What is said of a short run."""
    settings = task.plan.train.override({**SHORT, "algorithm": algorithm})
    judge = Evaluate(episodes=1, every=2000)
    plan = dataclasses.replace(task.plan, train=settings, evaluate=judge)
    with importable(plan.root):
        labels = labeller(plan)
        train(plan, task.demos, labels, run, Validator(plan, labels), lambda watched: None, {})
        return evaluate_run(plan, task.demos, labels, run, 1, {})[0]
