"""Formulas of linear temporal logic: reading, printing, rewriting, progression, words."""

from tiloilc.ltl.ast import propositions_of, subformulas
from tiloilc.ltl.fragments import (
    is_cosafety,
    is_eventual,
    is_propositional,
    is_safety,
    is_suspendable,
    is_universal,
)
from tiloilc.ltl.lasso import Lasso, holds
from tiloilc.ltl.normal import negation, nnf
from tiloilc.ltl.parser import Parsed, parse
from tiloilc.ltl.printer import name_text, to_text
from tiloilc.ltl.progress import after, unfold
from tiloilc.ltl.rewrite import simplify
from tiloilc.ltl.syntax import Syntax

__all__ = [
    "Lasso",
    "Parsed",
    "Syntax",
    "after",
    "holds",
    "is_cosafety",
    "is_eventual",
    "is_propositional",
    "is_safety",
    "is_suspendable",
    "is_universal",
    "name_text",
    "negation",
    "nnf",
    "parse",
    "propositions_of",
    "simplify",
    "subformulas",
    "to_text",
    "unfold",
]
