"""Findings for other programs to show: GitHub's annotations and SARIF 2.1.0."""

from __future__ import annotations

import json
from collections.abc import Sequence
from urllib.parse import quote

from tiloilc.diag.core import Diagnostic, Severity, Span
from tiloilc.diag.pages import meaning, page, readable, shown
from tiloilc.diag.registry import RULES
from tiloilc.diag.text import one_line

_SARIF_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
_COMMANDS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "notice"}


def render_github(diagnostics: Sequence[Diagnostic]) -> str:
    """Workflow commands, one line a finding: GitHub shows them beside the changed lines."""
    return "".join(_command(d) + "\n" for d in diagnostics)


def render_sarif(diagnostics: Sequence[Diagnostic]) -> str:
    """One SARIF run; columns are code points, ends are exclusive, as ours are."""
    codes = sorted({d.code for d in diagnostics}, key=list(RULES).index)
    rules = [
        {
            "id": code,
            "name": RULES[code].name,
            "fullDescription": {"text": meaning(code)},
            "help": {"text": readable(page(code)), "markdown": shown(page(code))},
            "defaultConfiguration": {"level": str(RULES[code].severity)},
        }
        for code in codes
    ]
    run = {
        "tool": {"driver": {"name": "tiloilc", "rules": rules}},
        "columnKind": "unicodeCodePoints",
        "results": [_result(d, codes.index(d.code)) for d in diagnostics],
    }
    document = {"$schema": _SARIF_SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def _command(diagnostic: Diagnostic) -> str:
    about = {"title": diagnostic.code}
    span = diagnostic.span
    if span is not None:
        place = {"file": span.file, "line": span.line, "endLine": span.end_line}
        if span.line == span.end_line:  # GitHub takes columns within one line only
            place |= {"col": span.column, "endColumn": span.end_column}
        about = {key: str(value) for key, value in place.items()} | about
    listed = ",".join(f"{key}={_escaped(value, ':,')}" for key, value in about.items())
    return f"::{_COMMANDS[diagnostic.severity]} {listed}::{_escaped(_said(diagnostic))}"


def _escaped(text: str, more: str = "") -> str:
    """Percent signs, line breaks and the signs of `more`, as GitHub wants them."""
    special = "%\r\n" + more
    return "".join(f"%{ord(c):02X}" if c in special else c for c in text)


def _said(diagnostic: Diagnostic) -> str:
    help = f"\nhelp: {one_line(diagnostic.help)}" if diagnostic.help else ""
    return one_line(diagnostic.message) + help


def _result(diagnostic: Diagnostic, rule: int) -> dict[str, object]:
    result: dict[str, object] = {
        "ruleId": diagnostic.code,
        "ruleIndex": rule,
        "level": str(diagnostic.severity),
        "message": {"text": _said(diagnostic)},
    }
    if diagnostic.span is not None:
        result["locations"] = [{"physicalLocation": _location(diagnostic.span)}]
    return result


def _location(span: Span) -> dict[str, object]:
    return {
        "artifactLocation": {"uri": quote(span.file)},
        "region": {
            "startLine": span.line,
            "startColumn": span.column,
            "endLine": span.end_line,
            "endColumn": span.end_column,
        },
    }
