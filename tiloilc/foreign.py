"""Environments are anyone's code: their observations as rows, and what goes wrong in them."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic

if TYPE_CHECKING:
    import gymnasium as gym

Floats = NDArray[np.float32]


@contextmanager
def blamed(id: str, fails: str, here: str) -> Iterator[None]:
    """Whatever goes wrong meanwhile is said to be the environment's: CompileError RUN707.

    It names the line that failed, unless that is in `here`, the file of the caller.
    """
    try:
        yield
    except (Exception, SystemExit) as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        ours = last.filename in (here, __file__)
        at = "" if ours else f" ({Path(last.filename).name}, line {last.lineno})"
        ends = isinstance(error, SystemExit)
        words = ["it ends the program"] if ends else str(error).strip().splitlines()
        problem = f"{fails}: {': '.join([type(error).__name__, *words[:1]])}{at}"
        raise CompileError(Diagnostic.of("RUN707", id=id, problem=problem)) from error


def dimensions_of(space: gym.Space[Any]) -> int:
    """Numbers in a flat observation: a Dict is flattened, anything else laid out as it is."""
    if space.shape is not None:
        return prod(space.shape)
    from gymnasium.spaces import flatdim

    return flatdim(space)


def flat(space: gym.Space[Any], observation: Any) -> Floats:
    """One observation of `space` as a row."""
    if space.shape is None:
        from gymnasium.spaces import flatten

        observation = flatten(space, observation)
    return np.asarray(observation, dtype=np.float32).reshape(-1)


def sized(space: gym.Space[Any], observation: Any, dimensions: int) -> Floats:
    """One observation, flat. Raises ValueError if it has not as many numbers as `dimensions`."""
    row = flat(space, observation)
    if row.size != dimensions:
        raise ValueError(f"an observation of {row.size} numbers, not {dimensions}")
    return row


def checked(space: gym.Space[Any], observation: Any, dimensions: int) -> Floats:
    """The same. Raises ValueError if it cannot be learned from."""
    row = sized(space, observation, dimensions)
    if not np.isfinite(row).all():
        raise ValueError("an observation that is not finite")
    return row
