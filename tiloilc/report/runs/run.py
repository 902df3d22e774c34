"""A run folder as values: what a report needs of `plan.json`, `events.jsonl`, `eval.json`, …

What is missing is said in `Run.notes`, so that an unfinished run can be looked at. What is there
but damaged is an error: a report must never show half of a file as if it were all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate import METRICS
from tiloilc.evaluate.records import Json
from tiloilc.plan.model import Plan
from tiloilc.report.runs.reading import (
    Floats,
    Object,
    Rewards,
    Unfit,
    floats,
    integer,
    mapping,
    parse,
    read_events,
    read_film,
    read_rewards,
    table,
    words,
)
from tiloilc.report.runs.verification import Verification, read_verification

__all__ = ["Curve", "Final", "Occupancy", "Run", "Trajectories", "read_run"]
from tiloilc.spec.laid import dotted


@dataclass(frozen=True)
class Curve:
    """Values over training: `values[name]` is [points, seeds], nan where there is none."""

    steps: tuple[int, ...]
    values: dict[str, Floats]


@dataclass(frozen=True)
class Occupancy:
    """The share of training steps spent in each automaton state: `shares` [points, states]."""

    steps: tuple[int, ...]
    shares: Floats


@dataclass(frozen=True)
class Trajectories:
    """One greedy episode a seed: `observations` [S, T+1, d] and automaton `states` [S, T+1]."""

    observations: npt.NDArray[np.float32]
    states: npt.NDArray[np.int64]


@dataclass(frozen=True)
class Final:
    """`eval.json`: each policy's metrics over seeds, [S], and the optimum if it is known.

    `greedy` and `stochastic` are of each seed's best policy by validation, `last` of the one that
    training ended with, `cloning` of the one it began with.
    """

    policies: dict[str, dict[str, Floats]]
    gamma: float | None
    episodes: int | None
    optimum: float | None
    optimum_exact: bool
    optimum_how: str
    wall_seconds: float | None
    machine: dict[str, str]
    git_commit: str | None


@dataclass(frozen=True)
class Run:
    """One run. `end` is how far it went, in environment steps of a seed; `root` is the folder of
    its task file; `film` is a GIF, empty if there is none or it is too large for a page.
    """

    folder: str
    root: Path
    name: str
    algorithm: str
    preset: str
    seeds: tuple[int, ...]
    plan_digest: str
    overrides: dict[str, str]
    versions: dict[str, str]
    end: int
    interrupted: bool
    plan: Plan | None
    curve: Curve
    losses: Curve
    occupancy: Occupancy | None
    final: Final | None
    trajectories: Trajectories | None
    rewards: Rewards | None
    verification: Verification | None
    film: bytes
    notes: tuple[str, ...]

    @property
    def shown(self) -> dict[str, object]:
        """Its demonstrations as settings; nothing if there is no plan to tell them."""
        return {} if self.plan is None else dotted(self.plan.demonstrations)

    @property
    def total(self) -> int | None:
        """How far the run was to go, if the plan or an override says so."""
        given = self.overrides.get("steps", "")
        if given.isdecimal():
            return int(given)
        return None if self.plan is None else self.plan.train.steps


def read_run(path: Path) -> Run:
    """The run in the folder `path`.

    Raises CompileError RUN701 if it is no run folder or one of its files is damaged, and what
    reading its plan raises.
    """
    if not path.is_dir():
        problem = "it is no folder" if path.exists() else "there is no such folder"
        raise _unreadable(path, problem)
    try:
        return _read(path)
    except Unfit as error:
        raise _unreadable(path, str(error)) from None


def _read(path: Path) -> Run:
    notes: list[str] = []
    evaluation = _optional(path, "eval.json")
    log = path / "events.jsonl"
    if evaluation is None and not log.is_file():
        raise Unfit("it has neither events.jsonl nor eval.json")
    events = read_events(log, notes)
    about = {**events.start, **(evaluation or {})}
    seeds = _seeds(about)
    plan = _plan(path, notes)
    if evaluation is None:
        notes.append("eval.json is missing: the run has not been evaluated at its end.")
    final = None if evaluation is None else _final(evaluation, len(seeds))
    curve = _curve(events.eval, "greedy", len(seeds))
    if not curve.steps and evaluation is not None:
        curve = _curve(_points(evaluation.get("curve")), "", len(seeds))
    end = events.last if log.is_file() else integer(about.get("steps"), "`steps`")
    return Run(
        folder=path.resolve().name,
        root=path if plan is None else path / plan.root,
        name=str(about.get("name", path.resolve().name)),
        algorithm=str(about.get("algorithm", "?")),
        preset=str(about.get("preset", "?")),
        seeds=seeds,
        plan_digest=str(about.get("plan_digest") or ""),
        overrides=words(about.get("overrides")),
        versions=words(about.get("versions")),
        end=end,
        interrupted=bool(about.get("interrupted", log.is_file() and not events.ended)),
        plan=plan,
        curve=curve,
        losses=_curve(events.train, "losses", len(seeds)),
        occupancy=_occupancy(events.train, len(seeds)),
        final=final,
        trajectories=_trajectories(path / "trajectories.npz", len(seeds), notes),
        rewards=read_rewards(path / "rewards.npz"),
        verification=read_verification(path / "verify.json"),
        film=read_film(path / "video.gif"),
        notes=tuple(notes),
    )


def _seeds(about: Object) -> tuple[int, ...]:
    seeds = about.get("seeds")
    if not isinstance(seeds, list) or not seeds:
        raise Unfit("neither the first event nor eval.json names its seeds")
    return tuple(integer(seed, "`seeds`") for seed in seeds)


def _plan(path: Path, notes: list[str]) -> Plan | None:
    from tiloilc.plan import from_json

    file = path / "plan.json"
    if not file.is_file():
        notes.append("plan.json is missing: the task, its automaton and settings are unknown.")
        return None
    try:
        return from_json(file.read_text(encoding="utf-8"), file.as_posix())
    except UnicodeDecodeError:
        raise Unfit("plan.json is damaged") from None


def _curve(events: Sequence[Object], key: str, seeds: int) -> Curve:
    """The values under `key` (or beside the step, if it is empty); of equal steps the last."""
    by_step = {integer(e.get("step"), "`step`"): e for e in events}
    rows = {
        step: mapping(event.get(key) if key else dict(event), f"`{key}` at step {step}")
        for step, event in sorted(by_step.items())
    }
    rows = {step: row for step, row in rows.items() if row}
    names = {name: None for row in rows.values() for name in row if key or name in METRICS}
    gap = np.full(seeds, np.nan)
    values = {
        name: np.array(
            [
                gap if row.get(name) is None else floats(row[name], f"`{name}` at step {at}", seeds)
                for at, row in rows.items()
            ]
        )
        for name in names
    }
    return Curve(tuple(rows), values)


def _points(value: Json) -> list[Object]:
    if not isinstance(value, list):
        return []
    return [mapping(point, "a point of `curve`") for point in value]


def _occupancy(events: Sequence[Object], seeds: int) -> Occupancy | None:
    steps: list[int] = []
    shares: list[Floats] = []
    for event in events:
        if event.get("stage_histogram") is None:
            continue
        where = f"`stage_histogram` at step {event.get('step')}"
        counts = table(event["stage_histogram"], where, seeds).sum(axis=0)
        if shares and counts.shape != shares[0].shape:
            raise Unfit(f"{where} has another number of states than before")
        if counts.sum() > 0:
            steps.append(integer(event.get("step"), "`step`"))
            shares.append(counts / counts.sum())
    return Occupancy(tuple(steps), np.stack(shares)) if shares else None


def _final(evaluation: Object, seeds: int) -> Final:
    policies = {}
    for policy in ("greedy", "stochastic", "last", "cloning"):
        metrics = mapping(evaluation.get(policy), f"`{policy}`")
        if metrics:
            policies[policy] = {
                name: floats(metrics[name], f"`{policy}.{name}`", seeds)
                for name in METRICS
                if name in metrics
            }
    optimum = mapping(evaluation.get("optimum"), "`optimum`")
    best = optimum.get("accepting_visits")
    gamma, wall = evaluation.get("gamma"), evaluation.get("wall_seconds")
    episodes, commit = evaluation.get("episodes"), evaluation.get("git_commit")
    return Final(
        policies=policies,
        gamma=float(gamma) if isinstance(gamma, int | float) else None,
        episodes=episodes if isinstance(episodes, int) else None,
        optimum=float(best) if isinstance(best, int | float) else None,
        optimum_exact=optimum.get("exact") is True,
        optimum_how=str(optimum.get("how") or ""),
        wall_seconds=float(wall) if isinstance(wall, int | float) else None,
        machine=words(evaluation.get("machine")),
        git_commit=commit if isinstance(commit, str) else None,
    )


def _trajectories(file: Path, seeds: int, notes: list[str]) -> Trajectories | None:
    if not file.is_file():
        notes.append("trajectories.npz is missing: no trajectories to show.")
        return None
    try:
        with np.load(file, allow_pickle=False) as arrays:
            observations = np.asarray(arrays["observations"], dtype=np.float32)
            states = np.asarray(arrays["states"], dtype=np.int64)
    except KeyError as error:
        raise Unfit(f"trajectories.npz: {str(error.args[0]).rstrip(' .')}") from None
    except Exception:  # zipfile, zlib and numpy each raise their own for a damaged archive
        raise Unfit("trajectories.npz is damaged") from None
    if observations.ndim != 3 or states.shape != observations.shape[:2] or len(states) != seeds:
        raise Unfit(
            f"trajectories.npz: observations {observations.shape} and states {states.shape} "
            f"are not one episode for each of {seeds} seeds"
        )
    return Trajectories(observations, states)


def _optional(path: Path, name: str) -> dict[str, Json] | None:
    file = path / name
    if not file.is_file():
        return None
    try:
        return parse(file.read_text(encoding="utf-8"), name)
    except UnicodeDecodeError:
        raise Unfit(f"{name} is damaged") from None


def _unreadable(path: Path, problem: str) -> CompileError:
    return CompileError(Diagnostic.of("RUN701", path=str(path), problem=problem))
