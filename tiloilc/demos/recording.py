"""Demonstrations made by the scripted experts that an environment publishes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np

from tiloilc import __version__
from tiloilc.demos.model import Demo, DemoSet
from tiloilc.diag import CompileError, Diagnostic, Span, did_you_mean
from tiloilc.foreign import blamed, checked, dimensions_of

if TYPE_CHECKING:
    import gymnasium

    from tiloilc.tasks import Expert

MAX_TRIES = 20
"""Episodes per demonstration kept: an expert that finishes less often than that is broken."""


def record(
    environment: str,
    kwargs: Mapping[str, Any] | None = None,
    *,
    horizon: int,
    expert: str | None = None,
    count: int = 5,
    seed: int = 0,
    noise: float | None = None,
    laps: int | None = None,
    span: Span | None = None,
) -> DemoSet:
    """Let an expert act in `count` episodes of at most `horizon` steps and keep what it does.

    `expert` names one of those that the environment publishes, or is `file.py:function` (see
    `tiloilc.demos.functions`); None: the environment's first. An episode in
    which the expert does not finish its rounds is kept only if no later one is better: up to
    MAX_TRIES are tried. Episode i begins with `reset(seed=seeds[i])`, the expert's own noise is
    drawn from the same seed. `noise` takes the place of the expert's own; 0 is none; so does `laps`
    of the rounds that it makes. Raises CompileError DEMO506 if there is no such expert, DEMO509 if
    it is no function or has no noise or rounds to set, RUN707 if the environment fails.
    """
    import gymnasium

    env = _make(environment, kwargs or {})
    chosen = _choose(env, environment, expert, span)
    if noise is not None:
        chosen = _changed(chosen, "noise", noise)
    if laps is not None:
        chosen = _changed(chosen, "laps", laps)
    episodes: list[Demo] = []
    seeds: list[int] = []
    unfinished: list[tuple[Demo, int]] = []
    for trial in range(seed, seed + MAX_TRIES * count):
        if len(episodes) == count:
            break
        demo, finished = _episode(env, environment, chosen, horizon, trial)
        if finished:
            episodes.append(demo)
            seeds.append(trial)
        else:
            unfinished.append((demo, trial))
    for demo, trial in unfinished[: count - len(episodes)]:
        episodes.append(demo)
        seeds.append(trial)
    env.close()
    meta: dict[str, Any] = {
        "schema_version": 1,
        "environment": {"id": environment, "kwargs": dict(kwargs or {}), "horizon": horizon},
        "expert": chosen.name,
        "fields": _fields(env),
        "seeds": seeds,
        "steps": [demo.steps for demo in episodes],
        "versions": {
            "gymnasium": gymnasium.__version__,
            **_physics(env),
            "numpy": np.__version__,
            "tiloilc": __version__,
        },
    }
    if noise is not None:
        meta["noise"] = noise
    if laps is not None:
        meta["laps"] = laps
    return DemoSet(tuple(episodes), meta)


def play(
    environment: str,
    kwargs: Mapping[str, Any] | None = None,
    *,
    horizon: int,
    expert: str,
    seeds: Sequence[int],
    noise: float | None = None,
) -> tuple[Demo, ...]:
    """What an expert does in the episodes of these seeds, whatever it comes to.

    For what else is given, and what is raised, see `record`.
    """
    env = _make(environment, kwargs or {})
    chosen = _choose(env, environment, expert, None)
    if noise is not None:
        chosen = _changed(chosen, "noise", noise)
    episodes = tuple(_episode(env, environment, chosen, horizon, seed)[0] for seed in seeds)
    env.close()
    return episodes


def expert_names(environment: str, kwargs: Mapping[str, Any] | None = None) -> tuple[str, ...]:
    """The experts that an environment publishes; empty if it has none."""
    from tiloilc.tasks import experts_of

    env = _make(environment, kwargs or {})
    names = tuple(expert.name for expert in experts_of(env))
    env.close()
    return names


def published_fields(
    environment: str, kwargs: Mapping[str, Any] | None = None
) -> dict[str, tuple[int, int]]:
    """The named slices [start, stop) of the observation that an environment publishes."""
    env = _make(environment, kwargs or {})
    fields = {name: (start, stop) for name, (start, stop) in _fields(env).items()}
    env.close()
    return fields


def _make(environment: str, kwargs: Mapping[str, Any]) -> gymnasium.Env[Any, Any]:
    import gymnasium

    if environment.startswith("tiloilc/"):
        import tiloilc.tasks  # noqa: F401  # registers the environments
    # how long an episode is, the task says, as in training
    unlimited = {"max_episode_steps": -1, "disable_env_checker": True}
    return gymnasium.make(environment, **{**unlimited, **kwargs})


def _choose(
    env: gymnasium.Env[Any, Any], environment: str, name: str | None, span: Span | None
) -> Expert:
    from tiloilc.tasks import experts_of

    if name is not None and (":" in name or name.endswith(".py")):
        from tiloilc.demos.functions import function_expert

        return function_expert(name, env.action_space)
    experts = experts_of(env)
    for expert in experts:
        if name in (None, expert.name):
            return expert
    named = "" if name is None else f" `{name}`"
    help = did_you_mean(name or "", (expert.name for expert in experts), listed="its experts")
    raise CompileError(
        Diagnostic.of("DEMO506", span, named=named, environment=environment, help=help)
    )


def _changed(expert: Expert, field: str, value: float) -> Expert:
    """The same expert with another value of one of its fields; functions make no rounds."""
    known = field in getattr(expert, "__dataclass_fields__", {})
    if not known or (field == "laps" and expert.laps < 1):
        problem = f"it has no {field} to set"
        raise CompileError(Diagnostic.of("DEMO509", reference=expert.name, problem=problem))
    like: Any = expert
    changed: Expert = dataclasses.replace(like, **{field: value})
    return changed


def _episode(
    env: gymnasium.Env[Any, Any], environment: str, expert: Expert, horizon: int, seed: int
) -> tuple[Demo, bool]:
    """One episode, and whether the expert finished its rounds in it."""
    from gymnasium.spaces import Discrete

    numbered = isinstance(env.action_space, Discrete)
    space, generator = env.observation_space, np.random.default_rng(seed)
    dimensions = dimensions_of(space)
    with blamed(environment, "reset() fails", __file__):
        observation, _ = env.reset(seed=seed)
        observations, actions = [checked(space, observation, dimensions).copy()], []
    progress = expert.begin(observation, generator)
    for _ in range(horizon):
        action, progress = expert.act(observation, progress, generator)
        if progress.done:
            break
        with blamed(environment, "step() fails", __file__):
            observation, _, terminated, truncated, _ = env.step(int(action) if numbered else action)
            observations.append(checked(space, observation, dimensions).copy())
        actions.append(np.asarray(action))
        if terminated or truncated:
            break
    _, progress = expert.act(observation, progress, generator)
    taken = np.array(actions) if actions else None
    return Demo(np.array(observations, np.float32), taken), progress.laps >= expert.laps


def _physics(env: gymnasium.Env[Any, Any]) -> dict[str, str]:
    """The version of MuJoCo, if the environment is made of it: the same actions may lead elsewhere
    in another."""
    model = getattr(env.unwrapped, "model", None)
    made_of = type(model).__module__.partition(".")[0]
    return {"mujoco": metadata.version("mujoco")} if made_of == "mujoco" else {}


def _fields(env: gymnasium.Env[Any, Any]) -> dict[str, list[int]]:
    published: Mapping[str, slice | int] = getattr(env.unwrapped, "observation_fields", {})
    return {
        name: [place, place + 1] if isinstance(place, int) else [place.start, place.stop]
        for name, place in sorted(published.items())
    }
