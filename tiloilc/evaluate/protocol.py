"""The protocol: which episodes judge a policy, and what is written of them (`eval.json`)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
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
    require_finished(run)
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
        "steps": settings.steps_taken,
        "seeds": list(range(settings.first_seed, settings.first_seed + settings.seeds)),
        "episodes": episodes,
        "gamma": GAMMA,
        **judged,
        "optimum": optimum_json(task_optimum_of(plan, labels)),
        "curve": _curve(last_events(run / EVENTS, "eval")),
        "interrupted": False,
        **about,
    }, trajectories


def require_finished(run: Path) -> None:
    """Raises CompileError RUN706 if the run has no last policy, RUN701 if it cannot be read."""
    if load_policy(run, "last") is None:
        help = f"tiloilc train {run.as_posix()} --resume"
        raise CompileError(Diagnostic.of("RUN706", help=help, path=run.as_posix()))


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
