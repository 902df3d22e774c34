"""Many copies of an environment with labels and automaton, beside one from `gymnasium.make`."""

from __future__ import annotations

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement
from tiloilc.bench.turns import Contestant, Tell, compare, take_turns

COPIES = 64
TASKS = {
    "FlatWorld": Work("flatworld_cycle", copies=COPIES),
    "GridCircular": Work("grid_circular_hard", copies=COPIES),
    "Carlo": Work("carlo", copies=COPIES),
    "SixteenRooms": Work("sixteen_rooms", copies=COPIES),
}


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark."""
    rows = []
    for name, work in TASKS.items():
        ours, rival = take_turns(
            [
                Contestant(f"{COPIES} copies", "ours", "product", work),
                Contestant("one gymnasium.make environment", "single", "steps", work),
            ],
            rounds,
            tell=tell,
        )
        rows.append(compare(f"{COPIES} copies of {name}", "steps/s", ours, rival, 10))
    return rows
