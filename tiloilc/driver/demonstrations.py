"""Whether demonstrations are of the environment that they are for, and lie in its spaces."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from tiloilc.demos import Demo, DemoSet
from tiloilc.diag import Diagnostic, Span
from tiloilc.driver.environment import Asked
from tiloilc.spec import Environment

if TYPE_CHECKING:
    import gymnasium
    import numpy as np
    from numpy.typing import NDArray

SLACK = 1e-3
"""Of the width of an action's bounds: recorded actions went through float32 and back."""


def fit_findings(demos: DemoSet, asked: Asked, span: Span | None = None) -> Iterator[Diagnostic]:
    """DEMO507 for each demonstration with states or actions that the environment does not have."""
    for index, demo in enumerate(demos.episodes):
        problem, help = _states(demo, asked), ""
        if not problem and demo.actions is not None:
            problem = _actions(demo.actions, asked.action_space)
            help = "correct them, or use `actions: inferred`"
        if problem:
            yield Diagnostic.of("DEMO507", span, index=index, problem=problem, help=help)


def origin_findings(
    demos: DemoSet, environment: Environment, span: Span | None = None
) -> Iterator[Diagnostic]:
    """DEMO508 if the sidecar names another environment, or other arguments of the same one."""
    made = demos.meta.get("environment")
    if not isinstance(made, dict) or not isinstance(made.get("id"), str):
        return
    named = [(made["id"], made.get("kwargs") or {}), (environment.id, environment.kwargs)]
    bare = [(name.rpartition(":")[2], kwargs) for name, kwargs in named]
    if bare[0] == bare[1]:
        return
    same = bare[0][0] == bare[1][0]
    said = [f"`{id}`" + (f" with {json.dumps(kwargs)}" if same else "") for id, kwargs in named]
    help = "record them in this environment, or correct the sidecar"
    yield Diagnostic.of("DEMO508", span, recorded=said[0], environment=said[1], help=help)


def _states(demo: Demo, asked: Asked) -> str:
    """What is wrong with its states; only a table has an end."""
    from tiloilc.product import bounds

    if not asked.finite:
        return ""
    low, high = bounds(asked.observation_space)
    seen = demo.observations
    outside = (seen < low) | (seen > high) | (seen != seen.round())
    return "its states are not all in the observation space" if outside.any() else ""


def _actions(actions: NDArray[np.generic], space: gymnasium.Space[Any]) -> str:
    """What is wrong with its actions [T, …]."""
    import numpy as np
    from gymnasium import spaces

    wanted = space.shape or ()
    rows = actions.astype(np.float64).reshape(len(actions), -1)
    if len(rows) and rows.shape[1] != int(np.prod(wanted)):
        return f"its actions have shape {list(actions.shape[1:])}, not {list(wanted)}"
    if isinstance(space, spaces.Discrete):
        first, last = int(space.start), int(space.start + space.n) - 1
        wrong = (rows < first) | (rows > last) | (rows != rows.round())
        return f"its actions are not all among {first} to {last}" if wrong.any() else ""
    assert isinstance(space, spaces.Box), "other spaces were refused"
    low, high = space.low.reshape(-1).astype(float), space.high.reshape(-1).astype(float)
    slack = SLACK * (high - low)
    wrong = (rows < low - slack) | (rows > high + slack)
    return "its actions are not all within the bounds of the action space" if wrong.any() else ""
