"""Predicate text to vectorised truth values over observations."""

from tiloilc.label.functions import CONSTANTS, FUNCTIONS
from tiloilc.label.labeller import Labeller, compile_predicates

__all__ = ["CONSTANTS", "FUNCTIONS", "Labeller", "compile_predicates"]
