"""A task so small that it is trained in a second, and records as a run of it would leave them."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from pathlib import Path

from tiloilc.evaluate import Record, split_seeds
from tiloilc.plan import digest
from tiloilc.sweep import Event, Experiment, Options, Outcome, Request, Started, check, requests
from tiloilc.sweep.work import Work

TASK = """\
name: corridor
environment: {id: tiloilc/GridAvoid-v0, kwargs: {distance: 3}, horizon: 8}
propositions:
  a: x >= 3 and y == 0
  z: y != 0
formula: "F a & G !z"
demonstrations: {source: expert, count: 2, actions: inferred}
train: {steps: 400, seeds: 2, learning_starts: 20, checkpoint_every: 50}
evaluate: {episodes: 2, every: 100}
"""


def task(folder: Path, name: str = "corridor", **replaced: str) -> Path:
    """The task file in a folder, under another name, with lines replaced."""
    text = TASK.replace("corridor", name)
    for key, line in replaced.items():
        lines = [line if old.startswith(f"{key}:") else old for old in text.splitlines()]
        text = "\n".join(lines) + "\n"
    path = folder / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def asked(path: Path, **options: object) -> list[Request]:
    """The requests of one file with options."""
    return requests([path], Options(**options))  # type: ignore[arg-type]


def experiments(path: Path, **options: object) -> list[Experiment]:
    """The experiments of one file with options."""
    return check(asked(path, **options))[0]


def records_of(
    one: Experiment, seeds: range, /, commit: str = "abc", **other: object
) -> list[Record]:
    """What a run of these seeds together leaves."""
    plan = one.plan_of(seeds)
    numbers = [float(seed) for seed in seeds]
    judged = {"accepting_visits": numbers, "violation_rate": [0.0 for _ in seeds]}
    fields: dict[str, object] = {
        "name": plan.name,
        "plan_digest": digest(plan),
        "algorithm": plan.train.algorithm,
        "preset": plan.train.preset,
        "overrides": plan.train.overrides(),
        "steps": plan.train.steps_taken,
        "seeds": list(seeds),
        "greedy": judged,
        "optimum": {"accepting_visits": 5.0, "exact": True},
        "curve": [],
        "interrupted": False,
        "git_commit": commit,
        **other,
    }
    spec = next(v for k, v in plan.digests.items() if k.startswith("spec:"))
    return split_seeds(fields, spec)  # type: ignore[arg-type]


class Feigned:
    """An engine that trains nothing: its jobs end as it was told, in the order it was told."""

    def __init__(self, outcomes: Mapping[str, Outcome]) -> None:
        self.outcomes = outcomes
        self.asked: list[str] = []

    def results(self, works: Sequence[Work]) -> Generator[Event, None, None]:
        """The outcomes of the jobs."""
        for work in works:
            self.asked.append(work.id)
            yield Started(work.id)
            yield None
            yield self.outcomes[work.id]
