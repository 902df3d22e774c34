"""Formulas of linear temporal logic: reading, printing, rewriting, progression, words."""

from tiloilc.ltl.lasso import Lasso, holds
from tiloilc.ltl.normal import nnf
from tiloilc.ltl.progress import after, unfold

__all__ = ["Lasso", "after", "holds", "nnf", "unfold"]
