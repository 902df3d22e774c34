"""Every diagnostic code: its severity, its message template and what it means."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """How grave a finding is; errors end the work, warnings do not."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Rule:
    """One diagnostic code. `message` is a format template; `explanation` is for `explain CODE`."""

    code: str
    severity: Severity
    name: str
    message: str
    explanation: str


def _rules(*rules: Rule) -> dict[str, Rule]:
    return {rule.code: rule for rule in rules}


E, W = Severity.ERROR, Severity.WARNING

RULES: dict[str, Rule] = _rules(
    Rule(
        "SPEC101",
        E,
        "unknown-key",
        "unknown key `{key}`",
        "The task file has a key that tiloilc does not know.",
    ),
    Rule(
        "LTL203",
        E,
        "unknown-proposition",
        "unknown proposition `{name}`",
        "The formula uses a name that is not declared under `propositions`.",
    ),
)
"""All rules by code, in the order of their codes."""
