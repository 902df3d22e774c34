"""The formulas that are measured without any file: those of the paper, and some made to explode."""

from __future__ import annotations

from typing import NamedTuple


class Known(NamedTuple):
    """A formula and the smallest automaton known for it before.

    `best` counts states with edge-based acceptance, without the sink; None if nobody has told.
    """

    text: str
    best: int | None = None


PAPER = {
    "avoid": Known("F a & G !z", 2),
    "sequential_2": Known("F (a & X F b)"),
    "sequential_3": Known("F (a & X F (b & X F c))", 4),
    "sequential_4": Known("F (a & X F (b & X F (c & X F d)))", 5),
    "sequential_5": Known("F (a & X F (b & X F (c & X F (d & X F e))))", 6),
    "circular_2": Known("G F (a & X F b) & G !z", 2),
    "circular_3": Known("G F (a & X F (b & X F c)) & G !z", 3),
    "circular_4": Known("G F (a & X F (b & X F (c & X F d))) & G !z", 4),
    "stabilization": Known("F G y & G !b", 2),
    "either_then": Known("(F (y & X F g) | F (r & X F g)) & G !b", 3),
    "button": Known("F grasp & G F (goal & X F button)", 3),
    "tray": Known("(!tray | F (grasp & X F intray)) & (tray | F (grasp & X F ingoal))", 6),
    "flip": Known("G F (b & X F d)", 2),
    "sixteen_rooms": Known(
        "(G F (r12 & X F (r14 & X F (r34 & X F r32)))"
        " | G F (r31 & X F (r33 & X F (r34 & X F (r44 & X F r43))))) & G !wall",
        10,
    ),
}
"""The formulas of the paper's tasks, in the order of its appendix."""

BOMBS = {
    "12 goals": " & ".join(f"G F a{i}" for i in range(12)),
    "GR(5)": " & ".join(f"(G F a{i} -> G F b{i})" for i in range(5)),
    "9 responses": " & ".join(f"G (a{i} -> X X X X F b{i})" for i in range(9)),
    "16 steps back": f"G (a -> {'X ' * 16}b)",
    "10 chains": " & ".join(f"F (a{i} & X F b{i})" for i in range(10)),
    "delayed weak until": "G (F a & (b U X X X X X X X X X (c W X X X X X X X X a)))",
}
"""Formulas whose automata grow exponentially, or would if they were built carelessly."""
