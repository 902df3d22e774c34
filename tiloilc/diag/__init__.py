"""Where something is and what we say about it."""

from tiloilc.diag.core import CompileError, Diagnostic, Severity, SourceText, Span, worst
from tiloilc.diag.registry import RULES, Rule

__all__ = [
    "RULES",
    "CompileError",
    "Diagnostic",
    "Rule",
    "Severity",
    "SourceText",
    "Span",
    "worst",
]
