"""The project's own benchmarks: what is measured, against what, and how it is told.

Each part is a module with `measure(rounds, tell)`, which gives rows of the table of goals; automata
have a page of their own besides.
"""

from tiloilc.bench.automata.formulas import BOMBS, PAPER, Known
from tiloilc.bench.automata.goals import measurements
from tiloilc.bench.automata.measure import (
    Alone,
    Figures,
    Measured,
    Row,
    measure,
    measure_alone,
    measure_known,
    measure_set,
)
from tiloilc.bench.automata.page import automata_page
from tiloilc.bench.automata.references import BadReferences, Reference, read_references
from tiloilc.bench.measurement import Measurement, Spread

__all__ = [
    "BOMBS",
    "PAPER",
    "Alone",
    "BadReferences",
    "Figures",
    "Known",
    "Measured",
    "Measurement",
    "Reference",
    "Row",
    "Spread",
    "automata_page",
    "measure",
    "measure_alone",
    "measure_known",
    "measure_set",
    "measurements",
    "read_references",
]
