"""The protocol: which episodes judge, what is written, and that judging disturbs nothing."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from tests.learn.examples import beyond, cell_is, demos, plan
from tests.plan.automata import automaton, ring, stabilization
from tiloilc.demos import DemoSet
from tiloilc.diag import CompileError
from tiloilc.evaluate.metrics import METRICS
from tiloilc.evaluate.protocol import (
    EVALUATION,
    VALIDATION,
    VALIDATION_EPISODES,
    Validator,
    dump,
    evaluate_run,
    metrics_of,
    optimum_json,
    task_optimum_of,
)
from tiloilc.evaluate.rollout import Arena, Rollout
from tiloilc.learn import make_loop, train
from tiloilc.plan import Plan, digest

Task = tuple[Plan, DemoSet, Callable[[Any], Any]]


def point(**changes: object) -> Task:
    made = plan(stabilization(), "TestsDrift-v0", steps=90, **changes)
    path = [[0.1 * t, 0.0] for t in range(8)]
    return made, demos(path, path), beyond(0.4, 1.5)


def trained(task: Task, run: Path) -> Path:
    made, shown, labels = task
    run.mkdir()
    train(made, shown, labels, run, Validator(made, labels), lambda seen: None, {})
    return run


@pytest.fixture(autouse=True)
def quick_cloning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)


def rollout(states: list[list[list[int]]], accepting: int, sink: int) -> Rollout:
    path = np.array(states)
    seen = np.zeros((*path.shape[:1], path.shape[2], 1), np.float32)
    return Rollout(seen, path, path == accepting, path == sink, np.zeros(path.shape, np.bool_))


def test_metrics_by_hand() -> None:
    """Two seeds, two episodes each of four steps; 1 accepts, 2 is the sink."""
    found = metrics_of(
        rollout(
            [
                [[0, 1, 0, 1, 1], [0, 0, 0, 0, 0]],
                [[1, 0, 2, 2, 2], [1, 1, 0, 0, 1]],
            ],
            accepting=1,
            sink=2,
        )
    )
    assert found.accepting_visits.tolist() == [1.5, 1.0]  # b_0 is no visit
    gains = [[1 + 0.99 + 0.99**2, 0], [1, 1 + 0.99 + 0.99**2]]  # b_0 is a term of Eq. 17
    assert found.eventual_return.tolist() == pytest.approx(np.mean(gains, axis=1))
    assert found.violation_rate.tolist() == [0, 0.5]
    assert found.success.tolist() == [0.5, 0.5]
    assert found.first_visit.tolist() == [1, 1]


def test_evaluation_seeds_are_never_those_of_validation_or_training() -> None:
    assert VALIDATION + 10**6 < EVALUATION
    made, shown, labels = point(seeds=3)
    loop = make_loop(made, shown, labels)
    everyone = np.ones(3, np.bool_)
    used = {seed for n in range(500) for seed in loop._seeds(np.full(3, n), everyone)}
    assert len(used) == 1500  # agents and episodes all differ
    judged = {*range(VALIDATION, VALIDATION + 1000), *range(EVALUATION, EVALUATION + 1000)}
    assert not used & judged


def test_validation_takes_no_random_numbers_from_the_agent() -> None:
    made, shown, labels = point()
    loop = make_loop(made, shown, labels)
    for _ in loop.run(70):
        pass
    before = loop.agent.state()["generator"].clone()
    validator = Validator(made, labels)
    first, second = validator(loop.agent), validator(loop.agent)
    assert first == second
    assert torch.equal(loop.agent.state()["generator"], before)


def test_validation_is_cheap() -> None:
    made, _, labels = point()
    assert Validator(made, labels).episodes == 3
    many = made.evaluate.model_copy(update={"episodes": 100})
    import dataclasses

    validator = Validator(dataclasses.replace(made, evaluate=many), labels)
    assert validator.episodes == VALIDATION_EPISODES


def test_what_is_written_of_a_run(tmp_path: Path) -> None:
    task = point()
    run = trained(task, tmp_path / "run")
    found, arrays = evaluate_run(*task, run, 4, {"overrides": {}})
    assert json.loads(dump(found)) == json.loads(json.dumps(found))
    for key in ("greedy", "stochastic", "last", "cloning"):
        assert tuple(found[key]) == METRICS, key
        assert all(len(values) == 2 for values in found[key].values())
    assert found["plan_digest"] == digest(task[0])
    assert (found["seeds"], found["steps"], found["episodes"]) == ([0, 1], 90, 4)
    assert [entry["step"] for entry in found["curve"]] == [40, 60, 80, 90]
    assert arrays["observations"].shape == (2, 11, 2)
    assert arrays["states"].shape == (2, 11)


def test_evaluating_twice_gives_the_same(tmp_path: Path) -> None:
    task = point()
    run = trained(task, tmp_path / "run")
    first, second = (evaluate_run(*task, run, 3, {})[0] for _ in range(2))
    assert first == second


def test_the_best_policy_is_judged_and_not_the_last(tmp_path: Path) -> None:
    """Swap the files of best and last: their metrics must swap too."""
    task = point()
    run = trained(task, tmp_path / "run")
    best, last = (run / "checkpoints" / f"{n}.safetensors" for n in ("best", "last"))
    cloned = (run / "checkpoints" / "cloning.safetensors").read_bytes()
    best.write_bytes(cloned)
    found, _ = evaluate_run(*task, run, 3, {})
    assert found["greedy"] == found["cloning"]
    best.write_bytes(last.read_bytes())
    found, _ = evaluate_run(*task, run, 3, {})
    assert found["greedy"] == found["last"]


def test_a_run_that_is_not_finished_cannot_be_evaluated(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    with pytest.raises(CompileError, match=r"RUN706"):
        evaluate_run(*point(), tmp_path / "run", 3, {})


def test_a_damaged_policy_is_a_finding(tmp_path: Path) -> None:
    task = point()
    run = trained(task, tmp_path / "run")
    path = run / "checkpoints" / "best.safetensors"
    path.write_bytes(path.read_bytes()[:50])
    with pytest.raises(CompileError, match=r"RUN701.*best.safetensors"):
        evaluate_run(*task, run, 3, {})


def test_a_policy_on_a_table_can_be_evaluated_too(tmp_path: Path) -> None:
    made = plan(
        ring(["far", "near"], "deadly"), "TestsLine-v0", horizon=6, kwargs={"size": 3}, steps=300
    )
    task = made, demos([0, 1, 2, 1, 0]), cell_is(2, 0, 9)
    found, _ = evaluate_run(*task, trained(task, tmp_path / "run"), 2, {})
    assert found["demonstrations"] == made.demonstrations.model_dump(exclude_none=True)
    assert found["greedy"]["accepting_visits"] == [1, 1]  # 6 steps: to 2, to 0, to 2
    assert found["cloning"] is None


def test_no_optimum_is_claimed_where_the_environment_says_nothing() -> None:
    made, _, labels = point()
    assert optimum_json(task_optimum_of(made, labels)) is None


def test_an_arena_can_be_used_again_and_again() -> None:
    ldba = automaton(["p"], 1, lambda b, true: 0, {0})
    made = plan(ldba, "TestsLine-v0", horizon=3)
    arena = Arena(made, cell_is(0), 2)
    loop = make_loop(made, DemoSet(()), cell_is(0))
    first, second = (arena.play(loop.agent, [1, 2]) for _ in range(2))
    assert np.array_equal(first.states, second.states)
    assert np.array_equal(first.observations, second.observations)
