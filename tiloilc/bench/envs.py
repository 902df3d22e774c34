"""Many copies of an environment with labels and automaton, beside one from `gymnasium.make`.

Copies of an array program are stepped together; those of a robot one by one, by a thread for each
core where that pays.
"""

from __future__ import annotations

from dataclasses import replace

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement, Spread
from tiloilc.bench.turns import Contestant, Tell, compare, take_turns

COPIES, ROBOTS = 64, 8
"""Copies of an array program, and of a robot."""

TASKS = {
    "FlatWorld": "flatworld_cycle",
    "GridCircular": "grid_circular_hard",
    "Carlo": "carlo",
    "SixteenRooms": "sixteen_rooms",
}
ROBOT_TASKS = {
    "FetchAvoid": "fetch_avoid",
    "FetchAlign": "fetch_align",
    "FetchPlaceTray": "fetchplace_tray",
    "FetchPlaceButton": "fetchplace_button",
    "DoggoAvoid": "doggo_avoid",
    "DoggoNavigate": "doggo_navigate",
    "CheetahFlip": "cheetah_flip",
}


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark."""
    rows = []
    for name, task in TASKS.items():
        rows += _rows(name, Work(task, copies=COPIES), 10, rounds, tell)
    for name, task in ROBOT_TASKS.items():
        work = Work(task, copies=ROBOTS, threads=True, needs=("mujoco", "gymnasium_robotics"))
        rows += _rows(name, work, None, rounds, tell)
    return rows


def _rows(name: str, work: Work, goal: float | None, rounds: int, tell: Tell) -> list[Measurement]:
    """How many times as fast as one, and what a million steps take."""
    told = f"{work.copies} copies of {name}" + (", by threads" if work.threads else "")
    one = replace(work, threads=False)
    ours, rival = take_turns(
        [
            Contestant(told, "ours", "product", work),
            Contestant("one gymnasium.make environment", "single", "steps", one),
        ],
        rounds,
        tell=tell,
    )
    million = [1e6 / rate for rate in ours.per_second]
    return [
        compare(told, "steps/s", ours, rival, goal),
        Measurement(f"a million steps of {name}", Spread.of(million) if million else None, "s"),
    ]
