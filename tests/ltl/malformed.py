"""Malformed formulas and what is said about them, to the letter.

`malformed.txt` has one after the other: `$ formula`, then what is printed; a line `declared: a, b`
says which propositions there are from then on (`any`: whatever appears). After a wanted change look
at each place, then write what is printed now: `python -m tests.ltl.malformed`
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tiloilc.diag import CompileError, render
from tiloilc.ltl import parse

FILE = Path(__file__).parent / "malformed.txt"


@dataclass(frozen=True)
class Case:
    """A malformed formula over declared propositions (None: any), and what is printed."""

    text: str
    declared: tuple[str, ...] | None
    printed: str


def cases(text: str) -> Iterator[Case]:
    """The cases of the file."""
    declared: tuple[str, ...] | None = None
    formula, printed = None, list[str]()
    for line in [*text.splitlines(), "$"]:
        if line.startswith(("$", "declared: ")) and formula is not None:
            yield Case(formula, declared, "\n".join(printed).strip("\n") + "\n")
            formula, printed = None, []
        if line.startswith("declared: "):
            names = line.removeprefix("declared: ")
            declared = None if names == "any" else tuple(names.split(", "))
        elif line.startswith("$"):
            formula = line.removeprefix("$ ").replace("⏎", "\n")
        elif formula is not None:
            printed.append(line)


def said(case: Case) -> str:
    """What is printed about a case; nothing if it can be read."""
    try:
        parse(case.text, case.declared)
    except CompileError as error:
        return render(error.diagnostics, "text", {"<formula>": case.text})
    return ""


def rewritten(text: str) -> str:
    """The file with what is printed now."""
    lines, declared = list[str](), ""
    for case in cases(text):
        names = "any" if case.declared is None else ", ".join(case.declared)
        if names != declared:
            lines += [f"declared: {names}", ""]
            declared = names
        shown = case.text.replace("\n", "⏎")
        lines += [f"$ {shown}".rstrip() if not case.text else f"$ {shown}", said(case)]
    return "\n".join(lines)


if __name__ == "__main__":
    FILE.write_text(rewritten(FILE.read_text(encoding="utf-8")), encoding="utf-8")
