"""The protocol: which episodes judge a policy, and what is written of them (`eval.json`)."""

from __future__ import annotations

import json
import platform
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tiloilc.demos import DemoSet
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate.metrics import EpisodeMetrics, measure
from tiloilc.evaluate.optimum import Optimum, task_optimum
from tiloilc.evaluate.rollout import Arena, Rollout
from tiloilc.evaluate.seeds import EVALUATION, VALIDATION
from tiloilc.learn import EVENTS, Labels, Metrics, Policy, last_events, load_policy, make_loop
from tiloilc.plan import Plan, digest
from tiloilc.spec.settings import Settings

GAMMA = 0.99
"""The discount of the paper's metric (Eq. 18), whatever an agent is trained with."""

VALIDATION_EPISODES = 5
"""Judging every few thousand steps must stay cheap beside learning."""

EVAL, TRAJECTORIES = "eval.json", "trajectories.npz"


class Validator:
    """Judges greedy policies while they are trained."""

    def __init__(self, plan: Plan, labels: Labels) -> None:
        self.episodes = min(plan.evaluate.episodes, VALIDATION_EPISODES)
        self.arena = Arena(plan, labels, self.episodes)

    def __call__(self, policy: Policy) -> Metrics:
        """The metrics of every seed's policy."""
        rollout = self.arena.play(policy, range(VALIDATION, VALIDATION + self.episodes))
        return metrics_of(rollout).to_json()


def metrics_of(rollout: Rollout) -> EpisodeMetrics:
    """The metrics of episodes, one value a seed."""
    accepting, sink = rollout.accepting, rollout.sink
    return measure(
        accepting[..., 1:], sink[..., 1:], gamma=GAMMA, start_accepting=accepting[..., 0]
    )


def evaluate_run(
    plan: Plan,
    demos: DemoSet,
    labels: Labels,
    run: Path,
    episodes: int,
    about: Mapping[str, object],
) -> tuple[dict[str, object], dict[str, NDArray[np.generic]]]:
    """Judge what a finished run left: the fields of `eval.json` and the arrays of trajectories.

    `greedy` and `stochastic` are of each seed's best policy by validation, `last` of the one at the
    end, `cloning` of the one before learning.

    Raises CompileError RUN706 if the run is not finished, RUN701 if a policy cannot be read.
    """
    if load_policy(run, "last") is None:
        help = f"tiloilc train {run.as_posix()} --resume"
        raise CompileError(Diagnostic.of("RUN706", help=help, path=run.as_posix()))
    arena = Arena(plan, labels, episodes)
    agent = make_loop(plan, demos, labels).agent
    seeds = range(EVALUATION, EVALUATION + episodes)
    judged: dict[str, object] = {}
    trajectories: dict[str, NDArray[np.generic]] = {}
    for name, key, greedy in (
        ("cloning", "cloning", True),
        ("last", "last", True),
        ("best", "greedy", True),
        ("best", "stochastic", False),
    ):
        policy = load_policy(run, name)
        if policy is None:
            judged[key] = None
            continue
        agent.load_policy(policy)
        rollout = arena.play(agent, seeds, greedy)
        judged[key] = metrics_of(rollout).to_json()
        if key == "greedy":
            states = np.where(rollout.over[:, 0], -1, rollout.states[:, 0])
            trajectories = {"observations": rollout.observations, "states": states}
    settings = plan.train
    return {
        "schema_version": 1,
        "name": plan.name,
        "plan_digest": digest(plan),
        "algorithm": settings.algorithm,
        "preset": settings.preset,
        "demonstrations": plan.demonstrations.model_dump(mode="json", exclude_none=True),
        "steps": steps_taken(settings),
        "seeds": list(range(settings.first_seed, settings.first_seed + settings.seeds)),
        "episodes": episodes,
        "gamma": GAMMA,
        **judged,
        "optimum": optimum_json(task_optimum_of(plan, labels)),
        "curve": _curve(last_events(run / EVENTS, "eval")),
        "interrupted": False,
        **about,
    }, trajectories


def steps_taken(settings: Settings) -> int:
    """Environment steps that were taken: cloning ends where learning would begin."""
    cloning = settings.algorithm == "cloning"
    return settings.learning_starts if cloning else settings.steps


def task_optimum_of(plan: Plan, labels: Labels) -> Optimum | None:
    """The best that any policy can do, where the environment says enough to compute it."""
    environment, epsilon = plan.environment, plan.train.epsilon
    return task_optimum(
        environment.id, environment.kwargs, labels, plan.ldba, environment.horizon, epsilon
    )


def optimum_json(optimum: Optimum | None) -> dict[str, object] | None:
    """The optimum as it stands in `eval.json`."""
    if optimum is None:
        return None
    return {
        "accepting_visits": float(optimum.accepting_visits),
        "exact": optimum.exact,
        "how": optimum.how,
    }


def machine() -> dict[str, object]:
    """What ran this, without names of hosts or people."""
    import os

    return {
        "system": platform.system(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
    }


def versions() -> dict[str, str]:
    """The versions of what decides results; MuJoCo's where a task has brought it in."""
    names = ["tiloilc", "torch", "numpy", "gymnasium"]
    names += [name for name in ("mujoco", "gymnasium-robotics") if _imported(name)]
    return {name: metadata.version(name) for name in names}


def _imported(distribution: str) -> bool:
    return distribution.replace("-", "_") in sys.modules


def git_commit(folder: Path) -> str | None:
    """The commit checked out in `folder`, None if there is none; `-dirty` if files differ."""
    return _git(folder, "describe", "--always", "--dirty", "--abbrev=40")


def git_time(folder: Path) -> int | None:
    """When that commit was made, in seconds since 1970; tells the later one of two records."""
    said = _git(folder, "show", "--no-patch", "--format=%ct", "HEAD")
    return int(said) if said is not None and said.isdecimal() else None


def _git(folder: Path, *arguments: str) -> str | None:
    """What git says of the checkout of `folder`; None if there is none, or no git."""
    command = ["git", "-C", str(folder), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None


def dump(evaluation: Mapping[str, object]) -> bytes:
    """`eval.json` as bytes."""
    return (json.dumps(evaluation, indent=1) + "\n").encode()


def _curve(events: Sequence[Mapping[str, object]]) -> list[dict[str, object]]:
    """The validation metrics over training, one entry an evaluation."""
    curve = []
    for event in events:
        greedy = event["greedy"]
        assert isinstance(greedy, dict)
        curve.append({"step": event["step"], **greedy})
    return curve
