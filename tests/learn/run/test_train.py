"""Runs that are interrupted, killed and damaged end as if nothing had happened, or say so."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from safetensors.torch import save

from tests.learn.examples import beyond, cell_is, demos, plan
from tests.plan.automata import automaton, ring, stabilization
from tiloilc.demos import DemoSet
from tiloilc.diag import CompileError
from tiloilc.evaluate.protocol import Validator
from tiloilc.learn import CHECKPOINTS, EVENTS, Outcome, Watched, load_policy, make_loop, train
from tiloilc.learn.engine.state import State
from tiloilc.learn.run.train import passed
from tiloilc.plan import Plan
from tiloilc.spec.presets import OF_ALGORITHM

Task = tuple[Plan, DemoSet, Callable[[Any], Any]]


def grid(**changes: object) -> Task:
    """A row of cells: visit the last, then the first; cell 2 of 7 is deadly."""
    made = plan(
        ring(["far", "near"], "deadly"), "TestsLine-v0", kwargs={"size": 7, "start": 3}, **changes
    )
    return made, demos([3, 4, 5, 6, 5, 4], [3, 4, 5]), cell_is(4, 3, 1)


def point(**changes: object) -> Task:
    """A point on a line: go out and back again, never too far."""
    ldba = automaton(
        ["out", "far"],
        3,
        lambda b, true: 2 if "far" in true else int("out" in true),
        {1},
        2,
    )
    made = plan(ldba, "TestsDrift-v0", **changes)
    path = [[0.1 * t, -0.05 * t] for t in range(8)]
    return made, demos(path, path[:5]), beyond(0.5, 1.2)


def stay(**changes: object) -> Task:
    """A point that must promise to stay outside, by an ε-jump."""
    made = plan(stabilization(), "TestsDrift-v0", **changes)
    path = [[0.1 * t, 0.0] for t in range(8)]
    return made, demos(path, path), beyond(0.4, 1.5)


def flatworld(**changes: object) -> Task:
    """The batched environment, with ε-jumps and a sink that ends episodes at odd times."""
    made = plan(stabilization(), "tiloilc/FlatWorld-v0", **changes)

    def labels(seen: np.ndarray) -> np.ndarray:
        yellow = np.hypot(seen[:, 0] + 0.85, seen[:, 1] - 0.15) < 0.3
        blue = np.hypot(seen[:, 0], seen[:, 1]) < 0.8
        return yellow.astype(np.int64) | (blue.astype(np.int64) << 1)

    path = [[-1.5 + 0.1 * t, 0.15] for t in range(7)]
    return made, demos(path), labels


TASKS = {"grid": grid, "point": point, "stay": stay, "flatworld": flatworld}


@pytest.fixture(autouse=True)
def quick_cloning(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is cloned need not be good here."""
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)


class Interrupt:
    """Watches a run and presses Ctrl-C after some steps."""

    def __init__(self, *at: int) -> None:
        self.at, self.steps = set(at), []

    def __call__(self, seen: Watched) -> None:
        import signal

        self.steps.append(seen.step)
        if seen.step in self.at:
            signal.raise_signal(signal.SIGINT)


def go(
    task: Task,
    run: Path,
    *interrupts: int,
    resume: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> Outcome:
    made, shown, labels = task
    run.mkdir(exist_ok=True)
    torch.set_num_threads(1)
    watch, about = Interrupt(*interrupts), {"name": "x"}
    return train(made, shown, labels, run, Validator(made, labels), watch, about, resume, say)


def same(first: State | None, second: State | None) -> bool:
    if first is None or second is None:
        return first is second
    return save(first) == save(second)  # byte by byte: not a number is equal to itself


def assert_equal_runs(first: Path, second: Path) -> None:
    assert (first / EVENTS).read_bytes() == (second / EVENTS).read_bytes()
    for name in ("cloning", "best", "last"):
        assert same(load_policy(first, name), load_policy(second, name)), name


def events(run: Path, kind: str) -> list[dict[str, Any]]:
    lines = [json.loads(line) for line in (run / EVENTS).read_text().splitlines()]
    return [line for line in lines if line["type"] == kind]


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("at", [(33,), (60,), (61, 62), (117, 150)])
def test_an_interrupted_run_goes_on_as_if_it_never_was(
    tmp_path: Path, name: str, at: Sequence[int]
) -> None:
    whole, pieces = tmp_path / "whole", tmp_path / "pieces"
    go(TASKS[name](steps=160), whole)
    for i, step in enumerate(at):
        outcome = go(TASKS[name](steps=160), pieces, step, resume=i > 0)
        assert (outcome.step, outcome.interrupted) == (step, True)
    assert not go(TASKS[name](steps=160), pieces, resume=True).interrupted
    assert_equal_runs(whole, pieces)


@pytest.mark.parametrize("name", TASKS)
def test_the_same_run_twice_gives_the_same_bytes(tmp_path: Path, name: str) -> None:
    for run in ("one", "two"):
        go(TASKS[name](steps=120), tmp_path / run)
    assert_equal_runs(tmp_path / "one", tmp_path / "two")


def test_another_first_seed_gives_another_run(tmp_path: Path) -> None:
    go(point(steps=80), tmp_path / "one")
    go(point(steps=80, first_seed=7), tmp_path / "two")
    assert not same(load_policy(tmp_path / "one", "last"), load_policy(tmp_path / "two", "last"))


@pytest.mark.parametrize("preset", ["paper", "default"])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"discriminator": "shared"},
        {"inference_growth": 1.3, "warm_start_steps": 40},
        {"stages": False},
        {"segment": False},
        {"accepting_target": "live"},
        {"accepting_target": "segment"},
        {"entropy": 0.1},
        {"updates_per_step": 0.3},
        {"algorithm": "cloning", "warm_start": "bc"},
    ],
    ids=lambda c: ",".join(f"{k}={v}" for k, v in c.items()) or "as it is",
)
def test_every_variant_trains_and_resumes(
    tmp_path: Path, preset: str, changes: Mapping[str, object]
) -> None:
    def task() -> Task:
        return point(preset=preset, steps=100, every=30, **changes)

    go(task(), tmp_path / "whole")
    go(task(), tmp_path / "pieces", 45)
    go(task(), tmp_path / "pieces", resume=True)
    assert_equal_runs(tmp_path / "whole", tmp_path / "pieces")
    losses = events(tmp_path / "whole", "train")[-1]["losses"]
    assert all(np.isfinite(v).all() for v in losses.values())


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("flatworld", {"epsilon": "step"}),
        ("stay", {"epsilon": "step", "accepting_target": "live"}),
        ("grid", {"preset": "paper"}),
        ("grid", {"entropy": "tuned", "target_entropy": 0.5}),
    ],
)
def test_jumps_that_take_a_step_and_temperatures_on_tables_resume(
    tmp_path: Path, name: str, changes: Mapping[str, object]
) -> None:
    def task() -> Task:
        return TASKS[name](steps=100, every=30, **changes)

    go(task(), tmp_path / "whole")
    go(task(), tmp_path / "pieces", 71)
    go(task(), tmp_path / "pieces", resume=True)
    assert_equal_runs(tmp_path / "whole", tmp_path / "pieces")


@pytest.mark.parametrize("algorithm", sorted(OF_ALGORITHM))
@pytest.mark.parametrize("name", ["grid", "point", "flatworld"])
def test_every_baseline_resumes(tmp_path: Path, name: str, algorithm: str) -> None:
    """Steps that wait to be judged, counts, rings of states: nothing is lost."""

    def task() -> Task:
        return TASKS[name](steps=100, every=30, algorithm=algorithm)

    go(task(), tmp_path / "whole")
    go(task(), tmp_path / "pieces", 41, 77)
    go(task(), tmp_path / "pieces", 77, resume=True)
    go(task(), tmp_path / "pieces", resume=True)
    assert_equal_runs(tmp_path / "whole", tmp_path / "pieces")


@pytest.mark.parametrize("algorithm", ["tiloil", "cycler"])
@pytest.mark.parametrize("name", ["grid", "flatworld"])
def test_copies_side_by_side_resume(tmp_path: Path, name: str, algorithm: str) -> None:
    """Three at a time: no setting is a multiple of three, and every due time is met."""

    def task() -> Task:
        return TASKS[name](steps=100, every=30, copies=3, algorithm=algorithm)

    outcome = go(task(), tmp_path / "whole")
    assert outcome.step == 102
    go(task(), tmp_path / "pieces", 69)
    go(task(), tmp_path / "pieces", resume=True)
    assert_equal_runs(tmp_path / "whole", tmp_path / "pieces")
    judged = [event["step"] for event in events(tmp_path / "whole", "eval")]
    cloned = [60] if algorithm == "tiloil" and name == "flatworld" else []
    assert judged == sorted({30, 60, 90, 102, *cloned})
    (loop,) = {len(event["visits"]) for event in events(tmp_path / "whole", "train")}
    assert loop == 2  # numbers are of seeds, not of copies


def test_what_is_due_is_met_once_whatever_the_stride() -> None:
    for stride in (1, 3, 7, 50):
        steps = range(stride, 500, stride)
        met = [step for step in steps if passed(step, stride, 20)]
        if stride <= 20:
            assert len(met) == max(steps) // 20
            assert all(0 <= step - 20 * (i + 1) < stride for i, step in enumerate(met))
        else:
            assert met == list(steps)


@pytest.mark.parametrize("name", ["stay", "line"])
def test_jumps_that_take_a_step_are_judged_after_training_as_in_it(
    tmp_path: Path, name: str
) -> None:
    """What a jump is paid comes from the discriminators: the policy takes them along."""
    made, shown, labels = stay(steps=120, epsilon="step")
    if name == "line":
        made = plan(made.ldba, "TestsLine-v0", steps=120, epsilon="step")
        shown, labels = demos([0, 1, 2, 3, 4]), cell_is(4, 9)
    loop, other = (make_loop(made, shown, labels) for _ in range(2))
    list(loop.run(120))
    d = loop.product.observations.shape[1]
    seen = np.arange(5, dtype=np.float32)[:, None].repeat(d, axis=1)
    paid = loop.agent.rewards(seen)
    assert not torch.equal(other.agent.rewards(seen), paid)
    other.agent.load_policy({k: v.clone() for k, v in loop.agent.policy().items()})
    assert torch.equal(other.agent.rewards(seen), paid)


def test_resuming_a_finished_run_changes_nothing(tmp_path: Path) -> None:
    go(grid(steps=80), tmp_path / "run")
    files = [tmp_path / "run" / EVENTS, *sorted((tmp_path / "run" / CHECKPOINTS).iterdir())]
    before = [path.read_bytes() for path in files]
    go(grid(steps=80), tmp_path / "run", resume=True)
    assert [path.read_bytes() for path in files] == before


def test_a_run_killed_after_a_checkpoint_loses_only_what_came_later(tmp_path: Path) -> None:
    class Killed(BaseException):
        pass

    def kill(seen: Watched) -> None:
        if seen.step == 110:
            raise Killed

    go(point(), tmp_path / "whole")
    made, shown, labels = point()
    (tmp_path / "killed").mkdir()
    with pytest.raises(Killed):
        train(
            made, shown, labels, tmp_path / "killed", Validator(made, labels), kill, {"name": "x"}
        )
    log = tmp_path / "killed" / EVENTS
    log.write_bytes(log.read_bytes() + b'{"type":"half a li')  # written while it was killed
    go(point(), tmp_path / "killed", resume=True)
    assert_equal_runs(tmp_path / "whole", tmp_path / "killed")


@pytest.mark.parametrize("part", [-1, 0, 1])
def test_a_damaged_last_checkpoint_is_replaced_by_the_one_before(tmp_path: Path, part: int) -> None:
    go(point(), tmp_path / "whole")
    go(point(), tmp_path / "run", 160)
    folder, said = tmp_path / "run" / CHECKPOINTS, []
    pointer = json.loads((folder / "last.json").read_text())
    assert len(pointer["rows"]) == 4  # of the steps 25, 75, 125 and 160
    file = folder / [pointer["state"], *pointer["rows"]][part]["name"]
    file.write_bytes(file.read_bytes()[:-1] + b"x")
    go(point(), tmp_path / "run", resume=True, say=said.append)
    before = "going on at step 150, from the checkpoint before the last"
    assert said == [f"{before}: {file.name} is damaged"]
    assert_equal_runs(tmp_path / "whole", tmp_path / "run")


def test_a_finished_run_that_is_resumed_is_said_to_be_finished(tmp_path: Path) -> None:
    said: list[str] = []
    first = go(point(steps=80), tmp_path / "run")
    again = go(point(steps=80), tmp_path / "run", resume=True, say=said.append)
    assert said == ["finished already, at step 80"]
    assert (again.step, again.interrupted) == (first.step, False)


def test_a_run_of_other_settings_cannot_be_resumed(tmp_path: Path) -> None:
    go(point(), tmp_path / "run", 30)
    with pytest.raises(CompileError, match="RUN704"):
        go(point(gamma=0.5), tmp_path / "run", resume=True)


def test_a_run_that_was_killed_before_its_first_checkpoint_begins_again(tmp_path: Path) -> None:
    said: list[str] = []
    go(point(steps=80), tmp_path / "whole")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / EVENTS).write_text('{"type": "start", "step": 0, "na')
    go(point(steps=80), tmp_path / "run", resume=True, say=said.append)
    assert said == ["beginning again: no checkpoint had been written"]
    assert_equal_runs(tmp_path / "whole", tmp_path / "run")


def test_seconds_are_counted_over_all_parts_of_a_run(tmp_path: Path) -> None:
    first = go(point(steps=80), tmp_path / "run", 40)
    pointer = json.loads((tmp_path / "run" / CHECKPOINTS / "last.json").read_text())
    assert 0 < pointer["seconds"] <= first.seconds
    assert go(point(steps=80), tmp_path / "run", resume=True).seconds > pointer["seconds"]


def test_an_environment_that_does_not_repeat_itself_is_found_out(tmp_path: Path) -> None:
    made, shown, labels = point()
    environment = made.environment.model_copy(update={"id": "TestsForgetful-v0"})
    import dataclasses

    task = dataclasses.replace(made, environment=environment), shown, labels
    go(task, tmp_path / "run", 33)
    with pytest.raises(CompileError, match="RUN705"):
        go(task, tmp_path / "run", resume=True)


def test_a_loss_that_is_not_finite_ends_the_run_with_a_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tiloilc.learn.agent.continuous import SacAgent

    nan = torch.full((2,), torch.nan)
    monkeypatch.setattr(SacAgent, "learn", lambda self, progress: {"critic": nan})
    with pytest.raises(CompileError, match=r"RUN702.*critic"):
        go(point(), tmp_path / "run")


def test_events_tell_the_whole_story(tmp_path: Path) -> None:
    go(grid(steps=160, every=50), tmp_path / "run")
    assert events(tmp_path / "run", "start") == [{"type": "start", "step": 0, "name": "x"}]
    steps = [e["step"] for e in events(tmp_path / "run", "eval")]
    assert {50, 100, 150, 160} <= set(steps)
    assert steps == sorted(set(steps))
    assert events(tmp_path / "run", "end") == [{"type": "end", "step": 160}]
    told = events(tmp_path / "run", "train")
    counted = np.sum([e["stage_histogram"] for e in told], axis=0)
    assert counted.shape == (2, 4)
    assert counted.sum(1).tolist() == [160, 160]  # every arrival of every seed, once


def test_old_checkpoints_are_removed_but_for_two(tmp_path: Path) -> None:
    go(point(), tmp_path / "run")
    names = sorted(p.name for p in (tmp_path / "run" / CHECKPOINTS).iterdir())
    numbered = [name.split(".") for name in names if name[0].isdigit()]
    assert [n[0] for n in numbered if n[1] != "rows"] == ["0000000175", "0000000200"]
    assert len([n for n in numbered if n[1] == "rows"]) == 8  # every 25 steps: four each
    assert [name for name in names if not name[0].isdigit()] == [
        "best.safetensors",
        "cloning.safetensors",
        "last.json",
        "last.safetensors",
        "previous.json",
    ]


def test_without_cloning_there_is_no_cloned_policy(tmp_path: Path) -> None:
    for name, task in {
        "table": grid(steps=80),
        "states": point(steps=80, actions="none"),
        "off": point(steps=80, warm_start="none"),
    }.items():
        go(task, tmp_path / name)
        assert load_policy(tmp_path / name, "cloning") is None, name
        assert load_policy(tmp_path / name, "last") is not None
    go(point(steps=80), tmp_path / "cloned")
    assert load_policy(tmp_path / "cloned", "cloning") is not None
