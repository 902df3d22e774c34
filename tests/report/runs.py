"""Run folders as training leaves them: FlatWorld Cycle, ten seeds, every number from one seed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from tiloilc.automaton.ldba import Cube, Edge, Ldba
from tiloilc.plan import Plan, Predicate, stage_plan, to_json
from tiloilc.spec.model import Demonstrations, Environment, Evaluate
from tiloilc.spec.settings import Settings

PREDICATES = (
    Predicate("r", "dist(pos, [0.45, -0.75]) < 0.3"),
    Predicate("g", "dist(pos, [0.45,  1.00]) < 0.3"),
    Predicate("y", "dist(pos, [-0.85, 0.15]) < 0.3"),
    Predicate("b", "norm(pos) < 0.8"),
)
CENTRES = np.array([[0.45, -0.75], [0.45, 1.0], [-0.85, 0.15], [0.0, 0.0]])
RADII = np.array([0.3, 0.3, 0.3, 0.8])
WAYPOINTS = np.array(
    [[-0.2, -1.1], [0.5, -0.95], [1.1, -0.5], [1.15, 0.4], [0.6, 1.1], [-0.4, 1.15], [-1.1, 0.5],
     [-1.02, 0.1], [-1.1, -0.7]]
)  # fmt: skip


def cycle() -> Ldba:
    """GF (r & XF (g & XF y)) & G !b over r, g, y, b (bits 0 to 3); 3 accepts, 4 is the sink."""

    def waiting(state: int, bit: int, onward: int, stay: int) -> list[Edge]:
        return [
            Edge(state, 4, (Cube(8, 8),)),
            Edge(state, onward, (Cube(8 | bit, bit),)),
            Edge(state, stay, (Cube(8 | bit, 0),)),
        ]

    edges = [*waiting(0, 1, 1, 0), *waiting(1, 2, 2, 1), *waiting(2, 4, 3, 2)]
    edges += [*waiting(3, 1, 1, 0), Edge(4, 4, (Cube(0, 0),))]
    names = (
        "F (r & X F (g & X F y)) & G !b", "F (g & X F y) & G !b", "F y & G !b",
        "GF (r & X F (g & X F y)) & G !b", "false",
    )  # fmt: skip
    return Ldba(("r", "g", "y", "b"), names, frozenset({3}), 4, tuple(sorted(edges)))


def plan(**changes: Any) -> Plan:
    ldba = cycle()
    fields: dict[str, Any] = {
        "name": "flatworld_cycle",
        "description": "Visit red, green and yellow in this order for ever; never touch blue.",
        "environment": Environment(id="tiloilc/FlatWorld-v0", horizon=50),
        "fields": {"pos": (0, 2)},
        "predicates": PREDICATES,
        "formula": "G F (r & X F (g & X F y)) & G !b",
        "ldba": ldba,
        "stages": stage_plan(ldba),
        "demonstrations": Demonstrations(
            source="expert", count=5, max_visits=2, actions="inferred"
        ),
        "train": Settings(steps=60_000),  # type: ignore[call-arg]
        "evaluate": Evaluate(episodes=20, every=5_000),
        "digests": {"spec:flatworld_cycle.yaml": "5e" * 32, "demos.npz": "d0" * 32},
        "version": "0.1.0",
    }
    return Plan(**{**fields, **changes})


def write_run(
    folder: Path,
    *,
    level: float = 3.4,
    seeds: int = 10,
    steps: int = 60_000,
    random: int = 5,
    reached: int | None = None,
    compiled: Plan | None = None,
    **changes: Any,
) -> Path:
    """A run folder whose greedy policies end at about `level` visits.

    `reached`: the run was cut short at this step, and was not evaluated. `changes` replace entries
    of eval.json and of the first event.
    """
    rng = np.random.default_rng(random)
    folder.mkdir(parents=True)
    about: dict[str, Any] = {
        "name": "flatworld_cycle", "plan_digest": "c5" * 32, "algorithm": "tiloil",
        "preset": "default", "overrides": {}, "seeds": list(range(seeds)),
        "versions": {"python": "3.11.9", "torch": "2.13.0", "gymnasium": "1.3.0"},
    }  # fmt: skip
    about |= {key: changes.pop(key) for key in list(changes) if key in about}
    (folder / "plan.json").write_text(to_json(plan() if compiled is None else compiled))

    half, speed = rng.normal(0.22, 0.05, seeds) * steps, steps / 14
    ends = np.clip(rng.normal(level, 0.35, seeds), 0, 4)
    rise = {at: 1 / (1 + np.exp(-(at - half) / speed)) for at in range(0, steps + 1, steps // 12)}
    events: list[dict[str, Any]] = [{"type": "start", "step": 0, **about}]
    curve = []
    for at, share in rise.items():
        visits = np.round(np.clip(ends * share + rng.normal(0, 0.12, seeds), 0, 4) * 20) / 20
        greedy = metrics(visits, np.clip(0.7 * (1 - share) + rng.normal(0, 0.03, seeds), 0, 1))
        if at:
            events.append(training(at, share, seeds, rng))
        events.append({"type": "eval", "step": at, "greedy": greedy})
        curve.append({"step": at, **greedy})
    if reached is not None:
        events = [event for event in events if event["step"] <= reached]
    else:
        events.append({"type": "end", "step": steps})
    lines = "".join(json.dumps(event) + "\n" for event in events)
    (folder / "events.jsonl").write_text(lines)

    if reached is None:
        cloned = metrics(np.round(rng.uniform(1.1, 2.0, seeds), 2), np.full(seeds, 0.35))
        last = metrics(visits * 0.9, np.clip(rng.normal(0.05, 0.05, seeds), 0, 1))
        sampled = metrics(visits * 0.8, np.clip(rng.normal(0.1, 0.05, seeds), 0, 1))
        evaluation = {
            "schema_version": 1, **about, "steps": steps, "episodes": 20, "gamma": 0.99,
            "greedy": greedy, "stochastic": sampled, "last": last,
            "cloning": cloned,
            "optimum": {"accepting_visits": 4.0, "exact": False,
                        "how": "dynamic programming on a lattice 0.1 m apart: a lower bound"},
            "curve": curve, "wall_seconds": 271.4, "machine": {"cpu": "2 × EPYC", "threads": 2},
            "git_commit": "1c580e2", "interrupted": False, **changes,
        }  # fmt: skip
        (folder / "eval.json").write_text(json.dumps(evaluation))
    observations, states = episodes(seeds, rng)
    np.savez(folder / "trajectories.npz", observations=observations, states=states)
    return folder


def metrics(visits: np.ndarray, violations: np.ndarray) -> dict[str, list[float | None]]:
    """All metrics of policies with so many visits, an entry a seed."""
    columns = {
        "accepting_visits": visits,
        "eventual_return": (1 - 0.99**visits) / 0.01,
        "violation_rate": np.round(violations * 20) / 20,
        "success": np.round(np.clip(visits, 0, 1) * 20) / 20,
        "first_visit": np.where(visits > 0.2, 26 - 3 * visits, np.nan),
    }
    return {
        name: [None if np.isnan(v) else round(float(v), 4) for v in column]
        for name, column in columns.items()
    }


def training(at: int, share: np.ndarray, seeds: int, rng: np.random.Generator) -> dict[str, Any]:
    """One line of the log of training; mass moves from the first state on to later ones."""
    counts = []
    for s in share:
        weights = np.array([1.2 - s, 0.35 + 0.4 * s, 0.1 + 0.6 * s, 0.01 + 0.16 * s, 1.5 * (1 - s)])
        counts.append(rng.multinomial(5000, weights / weights.sum()).tolist())
    return {
        "type": "train", "step": at, "visits": [None] * seeds if at < 6000 else share.tolist(),
        "violations": (1 - share).tolist(), "stage_histogram": counts,
        "losses": {
            "critic": (0.3 + 2 * np.exp(-at / 2e4) + rng.normal(0, 0.05, seeds)).tolist(),
            "discriminator": (0.7 * np.exp(-at / 3e4) + rng.uniform(0, 0.1, seeds)).tolist(),
        },
    }  # fmt: skip


def episodes(seeds: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Walks along the waypoints with noise, some into blue: float32 [S, 51, 2] and int [S, 51]."""
    ldba = cycle()
    observations = np.zeros((seeds, 51, 2), np.float32)
    states = np.zeros((seeds, 51), np.int64)
    for seed in range(seeds):
        place, goal, state = np.array([-1.0, -1.0]), 0, ldba.initial
        noise = 0.13 if seed % 4 == 3 else 0.03
        for t in range(51):
            inside = np.hypot(*(CENTRES - place).T) < RADII
            letter = int((inside * [1, 2, 4, 8]).sum())
            state = ldba.successor(state, letter)
            observations[seed, t], states[seed, t] = place, state
            if np.abs(WAYPOINTS[goal] - place).max() < 0.2:
                goal = (goal + 1) % len(WAYPOINTS)
            step = np.clip((WAYPOINTS[goal] - place) / 0.4, -1, 1)
            place = np.clip(place + 0.4 * step + rng.normal(0, noise, 2), -2, 2)
    return observations, states
