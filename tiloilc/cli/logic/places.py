"""Environments for `tiloilc viz --env`: the map or frames of a task, and a demonstration in it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tiloilc.cli.console import fail, guests
from tiloilc.cli.logic.subjects import subject_of
from tiloilc.diag import CompileError, Diagnostic

if TYPE_CHECKING:
    from tiloilc.demos import Demo, DemoSet, Labels
    from tiloilc.plan import Plan
    from tiloilc.report.maps import Map
    from tiloilc.report.pictures.canvas import Canvas, Pixels
    from tiloilc.report.pictures.environment import Shown
    from tiloilc.report.pictures.place import Episode


def environment_drawn(sources: Sequence[str], number: int) -> Canvas:
    """The picture of one task's environment, or a sheet of several, with a demonstration each.

    Raises CompileError JOB611 if there is nothing to draw of a single one.
    """
    from tiloilc.report.pictures.environment import environment_picture, sheet

    tasks = [_shown(source, number, alone=len(sources) == 1) for source in sources]
    if len(tasks) > 1:
        return sheet(tasks, f"{len(tasks)} tasks")
    return environment_picture(tasks[0])


def _shown(source: str, number: int, alone: bool) -> Shown:
    """What there is to show of a task; beside others a single frame is enough."""
    from tiloilc.driver import labeller
    from tiloilc.plan import importable
    from tiloilc.report.maps import map_of
    from tiloilc.report.pictures.environment import Shown
    from tiloilc.report.plane import plane_of
    from tiloilc.report.states import states_of

    known = subject_of(source)
    plan = known.plan
    if plan is None:
        raise fail("an automaton alone has no environment; give a task file or a plan")
    environment, root = plan.environment, Path(plan.root)
    with guests(), importable(root):
        demos = _with_actions(plan, known.demos)
        if len(demos) and number >= len(demos):
            raise fail(f"there are demonstrations 0 to {len(demos) - 1}, none number {number}")
        episode, about = None, ""
        if len(demos):
            episode, about = _episode(plan, demos, number, labeller(plan))
        seeds = demos.meta.get("seeds")
        seed = seeds[number] if isinstance(seeds, list) and number < len(seeds) else 0
        drawn = map_of(environment.id, dict(environment.kwargs), root, seed)
        if drawn is None and episode is not None:
            drawn = plane_of(plan, root, episode.observations)
        demo = demos.episodes[number] if len(demos) and isinstance(seeds, list) else None
        frames, problem = _frames(plan, demo, seed, drawn, episode, alone)
    if drawn is None and not frames and alone:
        problem = f"it publishes no scene(), and gives no frames: {problem}"
        raise CompileError(Diagnostic.of("JOB611", environment=environment.id, problem=problem))
    states = states_of(plan, len(plan.ldba.names))
    return Shown(plan.name, plan.goal, about, drawn, frames, episode, states)


def _with_actions(plan: Plan, otherwise: DemoSet | None) -> DemoSet:
    """The demonstrations of a plan with their actions, if they have some: to play them again."""
    from tiloilc.demos import DemoSet, demonstrations_for
    from tiloilc.driver import labeller

    environment = plan.environment
    try:
        return demonstrations_for(
            plan.demonstrations.model_copy(update={"actions": "recorded"}),
            environment,
            labeller(plan),
            plan.ldba,
            name=plan.name,
            folder=Path(plan.root),
        )
    except CompileError:  # states only, or a build folder whose task file is elsewhere
        return otherwise or DemoSet(())


def _episode(plan: Plan, demos: DemoSet, number: int, labels: Labels) -> tuple[Episode, str]:
    """A demonstration with its automaton states, cut as in training, and a line about it."""
    from tiloilc.demos import replay
    from tiloilc.report.pictures.place import Episode

    observations = demos.episodes[number].observations
    run = replay(observations, labels, plan.ldba, plan.demonstrations.max_visits)
    steps = len(run.states) - 1
    by = f" by `{demos.meta['expert']}`" if "expert" in demos.meta else ""
    visits = f"{run.visits} accepting visit{'' if run.visits == 1 else 's'}"
    about = f"demonstration {number}{by}: {steps} steps, {visits}"
    if run.violates_at is not None:
        about += f", lost at step {run.violates_at}"
    return Episode(observations[: steps + 1], run.states), about


def _frames(
    plan: Plan,
    demo: Demo | None,
    seed: int,
    drawn: Map | None,
    episode: Episode | None,
    alone: bool,
) -> tuple[dict[int, Pixels], str]:
    """Frames by step, unless they show what the map does; and why there are none.

    Without a demonstration that can be played again there is that of a beginning.
    """
    from tiloilc.report.pictures.environment import highlight, moments
    from tiloilc.report.pictures.frames import NoFrames, along

    steps = {0}
    if episode is not None:
        steps = set(moments(episode)) if alone else {highlight(episode, plan.ldba.accepting)}
    try:
        found = along(plan.environment, Path(plan.root), demo, seed, steps, drawn)
    except NoFrames as error:
        return {}, str(error)
    return found, ""
