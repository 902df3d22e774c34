"""Gathers findings, so that one fault does not hide the next."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TypeVar

from tiloilc.diag import CompileError, Diagnostic, Severity

T = TypeVar("T")


@dataclass
class Findings:
    """All findings so far."""

    found: list[Diagnostic] = field(default_factory=list)

    def attempt(self, step: Callable[[], T], unless: Iterable[str] = ()) -> T | None:
        """What `step` gives; None if it raises a CompileError, whose findings are kept.

        Codes in `unless` are left out: those that only follow from an earlier fault.
        """
        try:
            return step()
        except CompileError as error:
            codes = set(unless)
            self.add(d for d in error.diagnostics if d.code not in codes)
            return None

    def add(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Keep `diagnostics`."""
        self.found.extend(diagnostics)

    @property
    def failed(self) -> bool:
        """Whether there is an error among them."""
        return any(d.severity is Severity.ERROR for d in self.found)

    def ordered(self) -> list[Diagnostic]:
        """All findings once, sorted by place."""
        return sorted(dict.fromkeys(self.found), key=Diagnostic.sort_key)
