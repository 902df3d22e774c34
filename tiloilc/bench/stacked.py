"""Ten seeds as one program beside one after the other; networks 64 wide."""

from __future__ import annotations

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement
from tiloilc.bench.turns import Contestant, Tell, compare, take_turns

SEEDS = 10
NARROW = (64, 64)

OURS = Contestant(
    "tiloilc", "ours", "updates", Work(seeds=SEEDS, actor=NARROW, critic=NARROW), each=SEEDS
)
RIVAL = Contestant(
    "Stable-Baselines3, seed after seed", "sb3", "updates", Work(actor=NARROW, critic=NARROW)
)


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark."""
    ours, rival = take_turns([OURS, RIVAL], rounds, tell=tell)
    return [compare("ten stacked seeds, 64 wide", "seed-updates/s", ours, rival, 12)]
