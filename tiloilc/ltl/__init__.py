"""Formulas of linear temporal logic: reading, printing, rewriting, progression, words."""

from tiloilc.ltl.ast import propositions_of, subformulas
from tiloilc.ltl.lasso import Lasso, holds
from tiloilc.ltl.normal import negation, nnf
from tiloilc.ltl.progress import after, unfold

__all__ = [
    "Lasso",
    "after",
    "holds",
    "negation",
    "nnf",
    "propositions_of",
    "subformulas",
    "unfold",
]
