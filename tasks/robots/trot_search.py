"""`python -m tiloilc.tasks.robots.trot_search`: find Doggo's gait by the cross-entropy method.

Candidates are drawn around a mean, each walks straight on and around corners, and mean and spread
move to those of the best. What wins a round is tried from other starts, too, and the best there is
kept. It takes two or three minutes; the same seed finds the same gait on the same machine.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tiloilc.tasks.experts import Waypoint
from tiloilc.tasks.robots.doggo import DoggoAvoidEnv, DoggoEnv
from tiloilc.tasks.robots.trot import SWINGS, Trot, written

CANDIDATES = 64
BEST = 10
"""Of the candidates of a round, so many say where the next round looks."""

KEPT = 0.3
"""The share of the old mean and spread that is kept."""

Course = tuple[Waypoint, ...]

STRAIGHT: Course = (Waypoint((100.0, 0.0), 0.0),)
CORNERS: Course = tuple(
    Waypoint(aim, 0.3) for aim in ((0.8, -0.8), (1.6, 0.4), (2.8, 0.4), (2.8, -10.0))
)
"""Corners to both sides, and beyond them farther than anything comes in a trial."""

STEPS = 100
"""Of a trial, 10 s."""

STARTS = range(1000, 1004)
"""Seeds of the episodes that decide between the winners of the rounds."""

FREQUENCY = (0.3, 4.5)
"""Hz; beyond 5 Hz steps of 0.1 s cannot follow."""

MEAN = np.array([1.5, *(0.5, 0.0, 0.0) * len(SWINGS)])
SPREAD = np.array([0.7, *(0.3, 0.3, 1.8) * len(SWINGS)])
"""Where the search begins: frequency; amplitude, offset and phase of each swing."""


@dataclass(frozen=True, slots=True)
class Round:
    """One round of the search: its winner, what that is worth, and the mean worth of its BEST."""

    number: int
    trot: Trot
    worth: float
    mean: float


def search(rounds: int, seed: int) -> Iterator[Round]:
    """The rounds of the search, one after the other; all candidates of a round start alike."""
    generator = np.random.default_rng(seed)
    env = DoggoAvoidEnv()
    mean, spread = MEAN.copy(), SPREAD.copy()
    for number in range(1, rounds + 1):
        drawn = mean + spread * generator.standard_normal((CANDIDATES, len(MEAN)))
        drawn[:, 0] = np.clip(drawn[:, 0], *FREQUENCY)
        worths = np.array([worth(env, Trot.of(row), number) for row in drawn])
        best = np.argsort(-worths, kind="stable")[:BEST]
        mean = KEPT * mean + (1 - KEPT) * drawn[best].mean(axis=0)
        spread = KEPT * spread + (1 - KEPT) * drawn[best].std(axis=0) + 0.01
        yield Round(number, Trot.of(drawn[best[0]]), worths[best[0]], worths[best].mean())


def finalist(winners: Sequence[Trot]) -> tuple[Trot, float]:
    """The winner of a round that is worth most on the average of other starts, and how much."""
    env = DoggoAvoidEnv()
    worths = [float(np.mean([worth(env, trot, seed) for seed in STARTS])) for trot in winners]
    best = int(np.argmax(worths))
    return winners[best], worths[best]


def worth(env: DoggoEnv, trot: Trot, seed: int) -> float:
    """Metres along the way that a gait comes in both courses together, less twice the worst lean.

    The lean is 1 less the cosine of the angle between the trunk's vertical and the world's.
    """
    value = 0.0
    for course in (STRAIGHT, CORNERS):
        expert = replace(env.walker("course", trot, *course), noise=0.0)
        generator = np.random.default_rng(seed)
        observation, _ = env.reset(seed=seed)
        progress = expert.begin(observation, generator)
        lean = 0.0
        for _ in range(STEPS):
            action, progress = expert.act(observation, progress, generator)
            observation = env.step(action)[0]
            _, x, y, _ = (float(q) for q in observation[expert.orientation])
            lean = max(lean, 2 * (x * x + y * y))
        value += _come(course, progress.leg, observation[expert.position]) - 2 * lean
    return value


def _come(course: Course, leg: int, here: npt.NDArray[np.floating]) -> float:
    """Metres from the origin along a course to what is nearest to its next waypoint, `leg`."""
    corners = np.array([(0.0, 0.0), *(waypoint.aim for waypoint in course)])
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    return float(lengths[: leg + 1].sum() - np.hypot(*(corners[leg + 1] - here)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Search, and write the gait that is found."""
    parser = argparse.ArgumentParser(
        prog="python -m tiloilc.tasks.robots.trot_search", description=__doc__
    )
    parser.add_argument(
        "-o", "--out", type=Path, default=Path("trot.json"), help="file to write to"
    )
    parser.add_argument("--rounds", type=int, default=24)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args(arguments)
    winners = []
    for found in search(chosen.rounds, chosen.seed):
        sys.stderr.write(f"round {found.number}: {found.worth:.2f}, best {BEST} {found.mean:.2f}\n")
        winners.append(found.trot)
    trot, value = finalist(winners)
    sys.stderr.write(f"{chosen.out}: {value:.2f} on the average of {len(STARTS)} starts\n")
    chosen.out.write_text(written(trot, rounds=chosen.rounds, seed=chosen.seed), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
