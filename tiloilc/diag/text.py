"""Diagnostics for a person at a terminal: the source line, carets, a label and one help line."""

from __future__ import annotations

import io
import unicodedata
from collections.abc import Iterable, Iterator, Mapping

from tiloilc.diag.core import Diagnostic, Severity, Span

TAB = "    "
"""Tabs are shown as four spaces, so that carets stand right whatever the terminal's tab stops."""

MAX_LINES = 6
"""Of a longer stretch the first and last lines are shown, the middle left out."""

MAX_WIDTH = 160
"""Longer source lines are cut around the caret, in cells."""

BEFORE_CARET = 60
"""How much of a cut line is kept before the caret, in characters."""

Piece = tuple[str, str]
"""A piece of a line: a style (a key of STYLES) and the text."""

STYLES = {
    "plain": "",
    "error": "bold red",
    "warning": "bold yellow",
    "note": "bold cyan",
    "message": "bold",
    "gutter": "bold blue",
    "help": "bold green",
}


def render_text(
    diagnostics: Iterable[Diagnostic], sources: Mapping[str, str], *, colour: bool = False
) -> str:
    """One block a finding, a blank line between two; with ANSI colours if `colour`."""
    lines: list[list[Piece]] = []
    for diagnostic in diagnostics:
        if lines:
            lines.append([])
        lines.extend(_block(diagnostic, sources))
    if colour:
        return _coloured(lines)
    return "".join("".join(text for _, text in line).rstrip() + "\n" for line in lines)


def one_line(text: str) -> str:
    """`text` on one line that cannot disturb a terminal: control characters are escaped."""
    return "".join(
        c.encode("unicode_escape").decode("ascii") if unicodedata.category(c)[0] == "C" else c
        for c in text
    )


def source_lines(text: str) -> list[str]:
    """Lines as our places count them: only a line feed ends a line."""
    return [line.removesuffix("\r") for line in text.split("\n")]


def _block(diagnostic: Diagnostic, sources: Mapping[str, str]) -> Iterator[list[Piece]]:
    severity = diagnostic.severity
    style = severity if isinstance(severity, Severity) else "error"
    yield [
        (style, f"{severity}[{diagnostic.code}]"),
        ("message", f": {one_line(diagnostic.message)}"),
    ]
    span, gutter = diagnostic.span, " "
    if span is not None:
        lines = source_lines(sources[span.file]) if span.file in sources else []
        gutter = " " * len(str(min(span.end_line, len(lines)) if lines else span.line))
        place = f"{one_line(span.file)}:{span.line}:{span.column}"
        yield [("gutter", f"{gutter}--> "), ("plain", place)]
        if 1 <= span.line <= len(lines):
            yield [("gutter", f"{gutter} |")]
            yield from _excerpt(span, lines, gutter, style, diagnostic.label)
            if diagnostic.help:
                yield [("gutter", f"{gutter} |")]
    if diagnostic.help:
        yield [("gutter", f"{gutter} = "), ("help", "help"), ("plain", f": {diagnostic.help}")]


def _excerpt(
    span: Span, lines: list[str], gutter: str, style: str, label: str
) -> Iterator[list[Piece]]:
    """The lines of `span`, each with carets under its part of it; the label after the last."""
    last = min(span.end_line, len(lines))
    shown = [n for n in range(span.line, last + 1) if n == span.line or lines[n - 1].strip()]
    skipped = len(shown) > MAX_LINES
    if skipped:
        shown = [*shown[: MAX_LINES // 2], *shown[-(MAX_LINES // 2) :]]
    for position, number in enumerate(shown):
        if skipped and position == MAX_LINES // 2:
            yield [("gutter", "...")]
        line = lines[number - 1]
        indent = len(line) - len(line.lstrip())
        start = span.column - 1 if number == span.line else indent
        end = span.end_column - 1 if number == span.end_line else len(line.rstrip())
        text, start, end = _cut(line, start, max(end, start + 1))
        shown_text = "".join(_visible(c) for c in text)
        before = sum(cells(_visible(c)) for c in text[:start]) + max(0, start - len(text))
        under = sum(cells(_visible(c)) for c in text[start:end])
        yield [("gutter", f"{number:>{len(gutter)}} | "), ("plain", shown_text)]
        carets = " " * before + "^" * max(under, 1)
        ending = f" {one_line(label)}" if label and number == shown[-1] else ""
        yield [("gutter", f"{gutter} | "), (style, carets + ending)]


def _cut(line: str, start: int, end: int) -> tuple[str, int, int]:
    """A long line cut around [start, end), with the stretch's place in what is left."""
    if len(line) <= MAX_WIDTH:
        return line, start, end
    first = max(0, start - BEFORE_CARET)
    last = min(len(line), first + MAX_WIDTH)
    head, tail = "…" if first else "", "…" if last < len(line) else ""
    shift = len(head) - first
    return head + line[first:last] + tail, start + shift, min(end, last) + shift


def _visible(character: str) -> str:
    if character == "\t":
        return TAB
    category = unicodedata.category(character)
    return "\N{REPLACEMENT CHARACTER}" if category in ("Cc", "Cf", "Cs") else character


def cells(text: str) -> int:
    """How many terminal cells `text` takes: wide characters two, combining ones none."""
    return sum(
        0
        if unicodedata.combining(c) or unicodedata.category(c) in ("Mn", "Me")
        else 2
        if unicodedata.east_asian_width(c) in "WF"
        else 1
        for c in text
    )


def _coloured(lines: list[list[Piece]]) -> str:
    from rich.console import Console
    from rich.text import Text

    out = io.StringIO()
    console = Console(
        file=out, force_terminal=True, color_system="standard", soft_wrap=True, highlight=False
    )
    for line in lines:
        console.print(Text.assemble(*[(text, STYLES[style]) for style, text in line]))
    return out.getvalue()
