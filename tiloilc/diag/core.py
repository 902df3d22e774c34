"""Where something is and what we say about it: places, text with places, diagnostics."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tiloilc.diag.registry import RULES, Severity

__all__ = ["CompileError", "Diagnostic", "Severity", "SourceText", "Span", "worst"]


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """A stretch of a file. Lines and columns are 1-based code points; the end is exclusive."""

    file: str
    line: int
    column: int
    end_line: int
    end_column: int

    @classmethod
    def at(cls, file: str, line: int = 1, column: int = 1) -> Span:
        """One character: of a file as a whole, its first."""
        return cls(file, line, column, line, column + 1)


@dataclass(frozen=True, slots=True)
class SourceText:
    """A string that remembers where each of its characters stands in a file.

    A YAML scalar may be quoted, escaped or folded, so its value is not a slice of the file.
    `places[i]` is the (line, column) of `value[i]`; one more place marks the end.
    """

    value: str
    file: str
    places: tuple[tuple[int, int], ...]

    def __post_init__(self) -> None:
        assert len(self.places) == len(self.value) + 1

    @classmethod
    def plain(cls, value: str, file: str = "<formula>") -> SourceText:
        """Text that is its own file, as on a command line."""
        places = [(1, 1)]
        for character in value:
            line, column = places[-1]
            places.append((line + 1, 1) if character == "\n" else (line, column + 1))
        return cls(value, file, tuple(places))

    def span(self, start: int = 0, end: int | None = None) -> Span:
        """The file's stretch behind `value[start:end]`; an empty stretch covers one character."""
        last = len(self.value) if end is None else end
        line, column = self.places[min(start, len(self.value))]
        if last <= start:
            return Span.at(self.file, line, column)
        end_line, end_column = self.places[last - 1]
        return Span(self.file, line, column, end_line, end_column + 1)


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding. `label` stands beside the caret, `help` is at most one line, an action."""

    code: str
    severity: Severity
    message: str
    span: Span | None = None
    label: str = ""
    help: str = ""

    @classmethod
    def of(
        cls,
        code: str,
        span: Span | None = None,
        *,
        label: str = "",
        help: str = "",
        **about: object,
    ) -> Diagnostic:
        """A finding by its registered rule; `about` fills the rule's message template."""
        rule = RULES[code]
        return cls(code, rule.severity, rule.message.format(**about), span, label, help)

    def sort_key(self) -> tuple[str, int, int, str, str]:
        """By place, then by code: findings without a place come first."""
        if self.span is None:
            return ("", 0, 0, self.code, self.message)
        return (self.span.file, self.span.line, self.span.column, self.code, self.message)


class CompileError(Exception):
    """The user's input cannot be used; carries every finding that says why."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        super().__init__("; ".join(f"[{d.code}] {d.message}" for d in diagnostics))
        self.diagnostics = diagnostics


def worst(diagnostics: Iterable[Diagnostic]) -> Severity | None:
    """The gravest severity among `diagnostics`; None if there is none."""
    ranks = (Severity.NOTE, Severity.WARNING, Severity.ERROR)
    return max((d.severity for d in diagnostics), key=ranks.index, default=None)
