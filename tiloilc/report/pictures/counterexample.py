"""The picture of a way in which a policy fails."""

from __future__ import annotations

import textwrap
from pathlib import Path

from tiloilc.evaluate.verify import Counterexample
from tiloilc.plan import Plan
from tiloilc.report.maps import map_of
from tiloilc.report.pictures.canvas import Canvas
from tiloilc.report.pictures.environment import Shown, environment_picture
from tiloilc.report.pictures.place import Episode
from tiloilc.report.plane import plane_of
from tiloilc.report.states import states_of

LETTERS = 105
"""In a line of text as wide as the picture."""


def counterexample_picture(
    plan: Plan, policy: str, counterexample: Counterexample
) -> Canvas | None:
    """The way over the task's map, or the plane of its observations; None if it has neither."""
    path, environment, root = counterexample.path, plan.environment, Path(plan.root)
    drawn = map_of(environment.id, dict(environment.kwargs), root)
    drawn = drawn or plane_of(plan, root, path.observations)
    width = path.observations.shape[1]
    if drawn is None or not all(0 <= i < width for i in drawn.position):
        return None
    whose = f"how the policy `{policy}` of seed {counterexample.seed} fails"
    if path.loop is not None and path.lost(plan.ldba) is None:
        whose += ", what it repeats in black"
    lines = [f"{whose}:", *textwrap.wrap(counterexample.reason, LETTERS)]
    return environment_picture(
        Shown(
            plan.name,
            plan.goal,
            "\n".join(lines),
            drawn,
            {},
            Episode(path.observations, path.states, path.loop),
            states_of(plan, len(plan.ldba.names)),
        )
    )
