"""Our SAC beside Stable-Baselines3's on Pendulum: same hyper-parameters, same judgement.

`python -m tiloilc.bench.pendulum RECORDS PAGE` trains the seeds that RECORDS has not, a few minutes
each, adds them, and writes the page. No formula is involved: the reward is the environment's.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tiloilc.bench.markdown import table
from tiloilc.evaluate import Record, append, generator, read, summarise
from tiloilc.evaluate.provenance import git_commit, machine, versions
from tiloilc.spec.settings import Settings

HEAD = """\
# Pendulum: our SAC beside Stable-Baselines3's

Written by `make results`, not by hand, from the records in `results/sac/`. Both learn Pendulum-v1
from the environment's reward for {steps:,} steps, ours with everything about logic switched off and
all seeds as one program. The return is that of the greedy policy at the end, the mean of {episodes}
episodes, the same ones for all. Intervals are bootstrapped over seeds.

Told to both: {told}.

"""

NAME = "Pendulum-v1"
HORIZON = 200
TORQUE = 2.0

STEPS, SEEDS = 20_000, 5
EVERY, EPISODES, LAST_EPISODES = 2_000, 10, 20
FIRST_EVALUATION = 1_000_000
"""Where the seeds of evaluation episodes begin; training uses smaller ones."""

SETTINGS: Mapping[str, object] = {
    "gamma": 0.99,
    "tau": 0.005,
    "batch_size": 128,
    "buffer_size": 1_000_000,
    "learning_starts": 100,
    "actor_rate": 1e-3,
    "critic_rate": 1e-3,
    "actor_hidden": (64, 64),
    "critic_hidden": (64, 64),
    "entropy": "tuned",
    "target_entropy": -1.0,
    "layer_norm": False,
    "updates_per_step": 1.0,
}
"""What both are told: the usual ones, with nets and steps that solve Pendulum in minutes."""

OURS, THEIRS = "sac of tiloilc", "sac of stable-baselines3"

Act: TypeAlias = Callable[[NDArray[np.float32]], NDArray[np.floating]]
"""Greedy torques for observations [seed, n, 3]: [seed, n, 1]."""


@dataclass(frozen=True, slots=True)
class Point:
    """Mean return of each seed's greedy policy after `step` steps of training, [seed]."""

    step: int
    returns: tuple[float, ...]


def judge(act: Act, seeds: int, episodes: int) -> tuple[float, ...]:
    """Mean return over `episodes` episodes, the same ones for everybody."""
    worlds = _worlds(seeds * episodes)
    starts = [FIRST_EVALUATION + i % episodes for i in range(len(worlds))]
    seen = [world.reset(seed=s)[0] for world, s in zip(worlds, starts, strict=True)]
    total = np.zeros(len(worlds))
    for _ in range(HORIZON):
        actions = act(np.array(seen, np.float32).reshape(seeds, episodes, -1))
        steps = [w.step(a) for w, a in zip(worlds, actions.reshape(len(worlds), 1), strict=True)]
        seen = [step[0] for step in steps]
        total += [float(step[1]) for step in steps]
    return tuple(total.reshape(seeds, episodes).mean(1).tolist())


def train_ours(steps: int, first_seed: int, seeds: int, **changes: object) -> Iterator[Point]:
    """Train `seeds` agents as one program; judged every EVERY steps."""
    from tiloilc.learn.agent.plain import PlainSac

    given = {**SETTINGS, "steps": steps, "seeds": seeds, "first_seed": first_seed, **changes}
    agent = PlainSac(3, 1, settings := Settings.model_validate(given))
    rng = np.random.default_rng([first_seed, seeds])
    worlds, elapsed = _worlds(seeds), 0
    seen = np.array([w.reset(seed=first_seed + i)[0] for i, w in enumerate(worlds)], np.float32)
    for step in range(1, steps + 1):
        if step <= settings.learning_starts:
            action = rng.uniform(-1, 1, (seeds, 1, 1)).astype(np.float32)
        else:
            action = agent.act(seen[:, None], greedy=False)
        results = [w.step(TORQUE * a[0]) for w, a in zip(worlds, action, strict=True)]
        after = np.array([result[0] for result in results], np.float32)
        reward = np.array([[result[1]] for result in results])
        never = np.zeros((seeds, 1), np.bool_)
        agent.record(seen[:, None], action, reward, after[:, None], never)
        seen, elapsed = after, elapsed + 1
        if elapsed == HORIZON:
            seen = np.array([world.reset()[0] for world in worlds], np.float32)
            elapsed = 0
        if step > settings.learning_starts:
            agent.learn()
        if step % EVERY == 0 or step == steps:
            episodes = LAST_EPISODES if step == steps else EPISODES
            greedy: Act = lambda x: TORQUE * agent.act(x, greedy=True)  # noqa: E731
            yield Point(step, judge(greedy, seeds, episodes))


def train_theirs(steps: int, seed: int) -> Iterator[Point]:
    """Train one agent with Stable-Baselines3."""
    import gymnasium
    from stable_baselines3 import SAC
    from stable_baselines3.common.logger import Logger

    s = Settings.model_validate({**SETTINGS, "steps": steps})
    model = SAC(
        "MlpPolicy",
        gymnasium.make(NAME),
        learning_rate=s.actor_rate,
        buffer_size=s.buffer_size,
        learning_starts=s.learning_starts,
        batch_size=s.batch_size,
        tau=s.tau,
        gamma=s.gamma,
        target_entropy=s.target_entropy,
        policy_kwargs={"net_arch": {"pi": [*s.actor_hidden], "qf": [*s.critic_hidden]}},
        seed=seed,
        device="cpu",
    )
    model.set_logger(Logger(None, []))  # its own makes a folder

    def act(seen: NDArray[np.float32]) -> NDArray[np.floating]:
        return model.predict(seen[0], deterministic=True)[0][None]

    for step in range(EVERY, steps + 1, EVERY):
        model.learn(EVERY, reset_num_timesteps=False)
        episodes = LAST_EPISODES if step == steps else EPISODES
        yield Point(step, judge(act, 1, episodes))


def record(algorithm: str, first_seed: int, points: list[Point], seconds: float) -> list[Record]:
    """One record a seed of what was trained together in `seconds`."""
    commit = git_commit(Path(__file__).parent)
    shared: dict[str, Any] = {
        "schema_version": 1,
        "name": NAME,
        "algorithm": algorithm,
        "preset": "pendulum",
        "overrides": dict(SETTINGS),
        "steps": points[-1].step,
        "trained_together": len(points[-1].returns),
        "seconds": round(seconds, 1),
        "machine": machine(),
        "versions": {**versions(), "stable-baselines3": version("stable-baselines3")},
        "git_commit": commit,
    }
    return [
        Record.of(
            {
                **shared,
                "seed": first_seed + i,
                "return": points[-1].returns[i],
                "curve": [{"step": p.step, "return": p.returns[i]} for p in points],
            }
        )
        for i in range(len(points[-1].returns))
    ]


def returns(records: Sequence[Record], algorithm: str) -> NDArray[np.float64]:
    """The final returns of an implementation, one a seed."""
    chosen = [r.fields for r in records if r.fields["algorithm"] == algorithm]
    return np.array([fields["return"] for fields in chosen], np.float64)


def pendulum_page(records: Sequence[Record]) -> str:
    """The page as Markdown; the same records give the same text."""
    lines = []
    for algorithm in (OURS, THEIRS):
        found = returns(records, algorithm)
        summary = summarise(found, generator())
        assert summary is not None
        low, high = summary.mean_interval.low, summary.mean_interval.high
        lines.append(
            [
                algorithm,
                summary.count,
                f"{summary.mean:.1f} ± {summary.sd:.1f}",
                f"[{low:.1f}, {high:.1f}]",
                " ".join(f"{value:.1f}" for value in found),
            ]
        )
    told = ", ".join(f"{name} {json.dumps(value)}" for name, value in SETTINGS.items())
    columns = ("learner", "seeds", "return", "95 % of the mean", "each seed")
    return HEAD.format(steps=STEPS, episodes=LAST_EPISODES, told=told) + table(columns, lines)


def main() -> None:
    """Train what is missing, then write the page."""
    path, page = Path(sys.argv[1]), Path(sys.argv[2])
    known = read(path) if path.exists() else []
    if len(returns(known, OURS)) < SEEDS:
        _add(path, OURS, 0, train_ours(STEPS, 0, SEEDS))
    done = {r.fields["seed"] for r in known if r.fields["algorithm"] == THEIRS}
    for seed in range(SEEDS):
        if seed not in done:
            _add(path, THEIRS, seed, train_theirs(STEPS, seed))
    page.write_text(pendulum_page(read(path)), encoding="utf-8")


def _add(path: Path, algorithm: str, first_seed: int, training: Iterator[Point]) -> None:
    began, points = perf_counter(), []
    for point in training:
        told = " ".join(f"{value:.0f}" for value in point.returns)
        sys.stderr.write(f"{algorithm}, seed {first_seed}: step {point.step}, returns {told}\n")
        points.append(point)
    append(path, record(algorithm, first_seed, points, perf_counter() - began))


def _worlds(count: int) -> list[Any]:
    import gymnasium

    return [gymnasium.make(NAME).unwrapped for _ in range(count)]


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
