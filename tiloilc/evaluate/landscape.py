"""What a run's discriminators make of every place in a plane: Eq. 8's reward, for each stage."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.demos import DemoSet
from tiloilc.learn import Labels, trained_agent
from tiloilc.plan import Plan

if TYPE_CHECKING:
    from gymnasium import Space

REWARDS = "rewards.npz"

SIDE = 60
"""Points along each axis of a continuous plane: enough for a picture that is drawn smoothly."""


def landscape(
    plan: Plan, demos: DemoSet, labels: Labels, run: Path
) -> dict[str, NDArray[np.float32]] | None:
    """The arrays of `rewards.npz`, by the discriminators that the run in `run` ended with.

    `x` [w] and `y` [h] are values of the two components that an observation has, `rewards`
    [seed, state, h, w] what each automaton state pays there. None where an observation is no place
    in a bounded plane, where no discriminator has a say, and without a checkpoint.

    Raises CompileError RUN701 if the run's checkpoints cannot be read.
    """
    settings = plan.train
    if settings.stages and settings.beta == 0:
        return None
    found = trained_agent(plan, demos, labels, run)
    axes = None if found is None else _axes(found[0])
    if found is None or axes is None:
        return None
    agent, (x, y) = found[1], axes
    rows = [np.stack([x, np.full_like(x, value)], axis=1) for value in y]
    rewards = np.stack([agent.rewards(row).cpu().numpy() for row in rows], axis=2)
    return {"x": x, "y": y, "rewards": rewards.astype(np.float32)}


def _axes(space: Space[Any]) -> tuple[NDArray[np.float32], NDArray[np.float32]] | None:
    """The values of the two components: all of a few whole numbers, else SIDE even ones."""
    low, high = (np.asarray(getattr(space, name, ())) for name in ("low", "high"))
    if low.shape != (2,) or not np.isfinite([low, high]).all():
        return None
    whole = np.issubdtype(space.dtype, np.integer)
    if whole and (high - low >= 4 * SIDE).any():
        return None
    counts = (high - low + 1).astype(int) if whole else (SIDE, SIDE)
    x, y = (
        np.linspace(a, b, n, dtype=np.float32) for a, b, n in zip(low, high, counts, strict=True)
    )
    return x, y
