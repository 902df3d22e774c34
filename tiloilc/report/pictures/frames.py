"""Frames of an environment along an episode that is played again."""

from __future__ import annotations

import warnings
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tiloilc.demos import Demo
from tiloilc.plan import importable
from tiloilc.report.maps import Map
from tiloilc.report.pictures.canvas import Pixels
from tiloilc.report.pictures.place import shows_map
from tiloilc.spec import Environment

if TYPE_CHECKING:
    import gymnasium


class NoFrames(Exception):
    """An environment shows nothing, and why."""


def make(environment: Environment, root: Path, frames: bool = True) -> gymnasium.Env[Any, Any]:
    """The environment, with frames or without. Raises NoFrames if it cannot be made so."""
    import gymnasium

    import tiloilc.tasks  # noqa: F401  # registers the bundled environments

    how: dict[str, Any] = {"max_episode_steps": -1, "disable_env_checker": True}
    how |= {"render_mode": "rgb_array"} if frames else {}
    try:
        with importable(root), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a render mode that it does not have
            return gymnasium.make(environment.id, **{**how, **environment.kwargs})
    except Exception as error:  # an environment is anyone's code
        raise NoFrames(_words(error)) from error


def frame(env: gymnasium.Env[Any, Any]) -> Pixels:
    """What the environment shows now. Raises NoFrames if that is no picture."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            shown: object = env.render()
    except Exception as error:  # graphics fail in their own ways
        raise NoFrames(_words(error)) from error
    pixels = np.asarray(shown)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] < 3:
        raise NoFrames("its render() gives no picture in the mode rgb_array")
    return pixels[..., :3]


def along(
    environment: Environment,
    root: Path,
    demo: Demo | None,
    seed: int,
    steps: Collection[int],
    drawn: Map | None = None,
) -> dict[int, Pixels]:
    """Frames at the wanted steps of a demonstration that is played again from its seed.

    Without actions there is no more than the frame of a beginning. There are none where
    they would show what is `drawn` already. Raises NoFrames.
    """
    env = make(environment, root)
    try:
        env.reset(seed=seed)
        found = {0: frame(env)}
        if drawn is not None and shows_map(found[0], drawn):
            return {}
        if demo is not None and demo.actions is not None:
            for step, action in enumerate(demo.actions[: max(steps, default=0)], 1):
                env.step(action)
                if step in steps:
                    found[step] = frame(env)
            if 0 not in steps and len(found) > 1:
                del found[0]
    except NoFrames:
        raise
    except Exception as error:  # an environment is anyone's code
        raise NoFrames(_words(error)) from error
    finally:
        env.close()
    return found


def _words(error: BaseException) -> str:
    lines = str(error).partition(" was raised from the environment creator")[0].splitlines()
    return lines[0].strip().rstrip(".") if lines else type(error).__name__
