"""Where something is and what we say about it."""

from tiloilc.diag.core import CompileError, Diagnostic, Severity, SourceText, Span, worst
from tiloilc.diag.registry import RULES, Rule
from tiloilc.diag.render import FORMATS, exit_status, render
from tiloilc.diag.suggest import did_you_mean, nearest
from tiloilc.diag.words import counted

__all__ = [
    "FORMATS",
    "RULES",
    "CompileError",
    "Diagnostic",
    "Rule",
    "Severity",
    "SourceText",
    "Span",
    "counted",
    "did_you_mean",
    "exit_status",
    "nearest",
    "render",
    "worst",
]
