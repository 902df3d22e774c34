"""Findings as text: one function a format, all sorted by place, the same bytes everywhere."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence

from tiloilc.diag.core import Diagnostic, Severity, worst
from tiloilc.diag.services import render_github, render_sarif
from tiloilc.diag.text import one_line, render_text

SCHEMA_VERSION = 1
"""Of the JSON format; grows when a key changes its meaning or goes."""

_RANKS = (Severity.ERROR, Severity.WARNING, Severity.NOTE)


def render(
    diagnostics: Iterable[Diagnostic],
    format: str,
    sources: Mapping[str, str],
    *,
    colour: bool = False,
) -> str:
    """All findings, sorted by place, without repetitions, in one of FORMATS.

    `sources` is the text of each file that spans name; a file that is not in it is named without
    an excerpt. `colour` matters to `text` only. No finding gives an empty string, or a document
    with none.
    """
    ordered = sorted(dict.fromkeys(diagnostics), key=_order)
    if format == "text":
        return render_text(ordered, sources, colour=colour)
    return _RENDERERS[format](ordered)


def exit_status(diagnostics: Iterable[Diagnostic], deny_warnings: bool = False) -> int:
    """1 if there is an error, or a warning that is denied; else 0."""
    gravest = worst(diagnostics)
    denied = (Severity.ERROR, Severity.WARNING) if deny_warnings else (Severity.ERROR,)
    return int(gravest in denied)


def _order(diagnostic: Diagnostic) -> tuple[str, int, int, int, str, str, str, str, int, int]:
    """By place; at the same place the graver first, then whatever makes the order total."""
    d, span = diagnostic, diagnostic.span
    begin = (span.file, span.line, span.column) if span else ("", 0, 0)
    end = (span.end_line, span.end_column) if span else (0, 0)
    return (*begin, _RANKS.index(d.severity), d.code, d.message, d.label, d.help, *end)


def _concise(diagnostics: Sequence[Diagnostic]) -> str:
    """`file:line:column: severity[CODE] message`, one line a finding."""
    lines = []
    for d in diagnostics:
        place = f"{d.span.file}:{d.span.line}:{d.span.column}: " if d.span else ""
        lines.append(one_line(f"{place}{d.severity}[{d.code}] {d.message}") + "\n")
    return "".join(lines)


def _json(diagnostics: Sequence[Diagnostic]) -> str:
    """The schema of the contract; what a finding lacks is null."""
    entries = [
        {
            "code": d.code,
            "severity": str(d.severity),
            "message": d.message,
            "file": d.span.file if d.span else None,
            "line": d.span.line if d.span else None,
            "column": d.span.column if d.span else None,
            "end_line": d.span.end_line if d.span else None,
            "end_column": d.span.end_column if d.span else None,
            "help": d.help or None,
        }
        for d in diagnostics
    ]
    document = {"schema_version": SCHEMA_VERSION, "diagnostics": entries}
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


_RENDERERS: Mapping[str, Callable[[Sequence[Diagnostic]], str]] = {
    "concise": _concise,
    "json": _json,
    "sarif": render_sarif,
    "github": render_github,
}

FORMATS: tuple[str, ...] = ("text", *_RENDERERS)
"""What `render` and `lint --format` take."""
