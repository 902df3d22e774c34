"""A saved policy on film: one episode of it, with frames where the environment gives some."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tiloilc.deploy.policy import Policy
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate.seeds import EVALUATION
from tiloilc.foreign import flat
from tiloilc.report.maps import cropped, map_of
from tiloilc.report.pictures.film import Film, shown_steps
from tiloilc.report.pictures.frames import NoFrames, frame, make
from tiloilc.report.pictures.place import Episode
from tiloilc.report.plane import plane_of
from tiloilc.report.states import states_of

if TYPE_CHECKING:
    import gymnasium

    from tiloilc.report.pictures.canvas import Pixels


LOST = 12
"""Steps that are still shown of an episode that is lost for ever."""


def film_of(policy: Policy) -> tuple[Film, str]:
    """The first evaluation episode of `policy`, and why it has no frames; empty if it has.

    Where the environment cannot show itself, its map is drawn, or the plane of its observations.
    A lost episode ends soon. Raises CompileError RUN711 if there is nothing to show.
    """
    plan, root = policy.plan, Path(policy.plan.root)
    environment = plan.environment
    drawn, problem = map_of(environment.id, dict(environment.kwargs), root), ""
    try:
        env = make(environment, root)
    except NoFrames as error:
        problem = str(error)
        env = make(environment, root, frames=False)
    try:
        episode, frames, failure = _played(policy, env, wanted=not problem)
    finally:
        env.close()
    problem = problem or failure
    if problem:
        frames = {}
        drawn = drawn or plane_of(plan, root, episode.observations)
        if drawn is None:
            problem = f"it publishes no scene(), and gives no frames: {problem}"
            raise CompileError(Diagnostic.of("RUN711", subject=environment.id, problem=problem))
        drawn = cropped(drawn, drawn.places(episode.observations))
    fps = float(env.metadata.get("render_fps") or 10)
    states = states_of(plan, len(plan.ldba.names))
    title = f"{plan.name}, seed {policy.seed}"
    return Film(title, plan.goal, episode, states, drawn, frames, fps), problem


def _played(
    policy: Policy, env: gymnasium.Env[Any, Any], wanted: bool
) -> tuple[Episode, dict[int, Pixels], str]:
    """An episode with the frames of the steps that are shown, and why there are no more."""
    horizon = policy.plan.environment.horizon
    steps = set(shown_steps(horizon)) if wanted else set()
    frames: dict[int, Pixels] = {}
    problem = ""
    policy.reset()
    observation, _ = env.reset(seed=EVALUATION)
    seen, states, over, lost = [], [], False, 0
    for step in range(horizon + 1):
        seen.append(flat(env.observation_space, observation))
        action = policy.act(seen[-1])
        states.append(policy.state)
        lost = lost + 1 if policy.lost else 0
        last = step == horizon or over or lost > LOST
        if step in steps or (last and wanted):
            try:
                frames[step] = frame(env)
            except NoFrames as error:
                problem, wanted, steps = str(error), False, set()
        if last:
            break
        observation, _, over, _, _ = env.step(action)
    episode = Episode(np.array(seen, np.float32), np.array(states, np.int64))
    kept = shown_steps(len(states) - 1)
    return episode, _filled(frames, kept), problem


def _filled(frames: dict[int, Pixels], steps: list[int]) -> dict[int, Pixels]:
    """A frame for each of `steps`: an episode that ends early shows steps that were left out."""
    there = sorted(frames)
    if not there:
        return {}
    return {step: frames[max(t for t in there if t <= step)] for step in steps}
