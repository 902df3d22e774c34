"""The paper's formulas and what is known about their automata."""

from __future__ import annotations

from typing import NamedTuple

from tiloilc.bench import PAPER as FORMULAS


class Known(NamedTuple):
    """A formula; its states without the sink, with marked edges and with accepting states."""

    text: str
    edge: int
    state: int
    jumps: int = 0


SIZES = {
    "avoid": (2, 2),
    "sequential_2": (3, 3),
    "sequential_3": (4, 4),
    "sequential_4": (5, 5),
    "sequential_5": (6, 6),
    "circular_2": (2, 3),
    "circular_3": (3, 4),
    "circular_4": (4, 5),
    "stabilization": (2, 2, 1),
    "either_then": (3, 3),
    "button": (3, 4),
    "tray": (6, 6),
    "flip": (2, 3),
    "sixteen_rooms": (10, 12, 2),
}
"""States with marked edges, with accepting states, and jumps."""

PAPER = {name: Known(known.text, *SIZES[name]) for name, known in FORMULAS.items()}
