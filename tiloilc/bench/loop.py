"""Environment, acting, storing and one update, step by step, one seed."""

from __future__ import annotations

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement
from tiloilc.bench.turns import Contestant, Tell, compare, take_turns

TASKS = {
    "FlatWorld": Work("flatworld_cycle"),
    "HalfCheetah": Work("halfcheetah", needs=("mujoco",)),
}


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark."""
    rows = []
    for name, work in TASKS.items():
        ours, rival = take_turns(
            [
                Contestant("tiloilc", "ours", "steps", work),
                Contestant("Stable-Baselines3's learn()", "sb3", "steps", work),
            ],
            rounds,
            tell=tell,
        )
        rows.append(compare(f"environment to update, {name}", "steps/s", ours, rival, 3))
    return rows
