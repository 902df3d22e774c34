"""Rewriting formulas into simpler equivalent ones."""

from tiloilc.ltl.rewrite.driver import RULES, Rule, simplify

__all__ = ["RULES", "Rule", "simplify"]
