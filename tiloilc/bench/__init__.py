"""The project's own benchmarks: what is measured, against what, and how it is told."""

from tiloilc.bench.automata.formulas import BOMBS, PAPER, Known
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

__all__ = [
    "BOMBS",
    "PAPER",
    "Alone",
    "BadReferences",
    "Figures",
    "Known",
    "Measured",
    "Reference",
    "Row",
    "automata_page",
    "measure",
    "measure_alone",
    "measure_known",
    "measure_set",
    "read_references",
]
