"""`python -m tiloilc.tasks.robots.flip_best`: Cheetah flips as often as a patient planner can.

Writes what is seen in one episode: the best that is known of the task. It takes a few minutes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tiloilc.tasks.experts import Expert
from tiloilc.tasks.known import played
from tiloilc.tasks.robots.flips import FlipExpert

SAMPLES = 128
HORIZON = 16
"""More than an expert that is to be quick can afford."""

STEPS = 1000
"""As many as the task has."""


def patient(expert: Expert) -> FlipExpert:
    """An expert without noise and without an end that tries more, and looks farther ahead."""
    assert isinstance(expert, FlipExpert)
    return replace(expert, noise=0.0, laps=STEPS, samples=SAMPLES, horizon=HORIZON)


def shipped_flips() -> npt.NDArray[np.float32]:
    """The episode in `assets/flips.npy`, float32 [1001, 18]."""
    with (files("tiloilc.tasks.robots") / "assets" / "flips.npy").open("rb") as file:
        episode: npt.NDArray[np.float32] = np.load(file, allow_pickle=False)
    return episode


def main(arguments: Sequence[str] | None = None) -> int:
    """Let it flip, and write what is seen."""
    from tiloilc.tasks.robots.cheetah import CheetahFlipEnv, rotations

    parser = argparse.ArgumentParser(
        prog="python -m tiloilc.tasks.robots.flip_best", description=__doc__
    )
    parser.add_argument("-o", "--out", type=Path, default=Path("flips.npy"), help="file to write")
    parser.add_argument("--steps", type=int, default=STEPS)
    chosen = parser.parse_args(arguments)
    env = CheetahFlipEnv()
    (expert,) = env.experts()
    (episode,) = played(env, patient(expert), chosen.steps, 1, "").observations
    np.save(chosen.out, episode)
    sys.stderr.write(f"{chosen.out}: {rotations(episode)[-1]:.1f} full turns\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
