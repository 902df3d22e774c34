"""The paper's formulas and what is known about their automata."""

from __future__ import annotations

from typing import NamedTuple


class Known(NamedTuple):
    """A formula; its states without the sink, with marked edges and with accepting states."""

    text: str
    edge: int
    state: int
    jumps: int = 0


PAPER = {
    "avoid": Known("F a & G !z", 2, 2),
    "sequential_2": Known("F (a & X F b)", 3, 3),
    "sequential_3": Known("F (a & X F (b & X F c))", 4, 4),
    "sequential_4": Known("F (a & X F (b & X F (c & X F d)))", 5, 5),
    "sequential_5": Known("F (a & X F (b & X F (c & X F (d & X F e))))", 6, 6),
    "circular_2": Known("G F (a & X F b) & G !z", 2, 3),
    "circular_3": Known("G F (a & X F (b & X F c)) & G !z", 3, 4),
    "circular_4": Known("G F (a & X F (b & X F (c & X F d))) & G !z", 4, 5),
    "stabilization": Known("F G y & G !b", 2, 2, jumps=1),
    "either_then": Known("(F (y & X F g) | F (r & X F g)) & G !b", 3, 3),
    "button": Known("F grasp & G F (goal & X F button)", 3, 4),
    "tray": Known("(!tray | F (grasp & X F intray)) & (tray | F (grasp & X F ingoal))", 6, 6),
    "flip": Known("G F (b & X F d)", 2, 3),
    "sixteen_rooms": Known(
        "(G F (r12 & X F (r14 & X F (r34 & X F r32)))"
        " | G F (r31 & X F (r33 & X F (r34 & X F (r44 & X F r43))))) & G !wall",
        10,
        12,
        jumps=2,
    ),
}
