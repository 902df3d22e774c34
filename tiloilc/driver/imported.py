"""An automaton that the task file names instead of a formula, and what can be said about it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tiloilc.automaton import from_hoa, is_empty, rejected_word
from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.spec import Document

UNIVERSAL_STATES = 2_000
UNIVERSAL_SECONDS = 2.0
"""Beyond these nobody asks whether an automaton accepts everything."""


def imported(document: Document) -> Ldba:
    """The automaton in the file that `automaton:` names, over the declared propositions.

    Raises CompileError SPEC105 if the file cannot be read, and AUT302 to AUT307.
    """
    name = document.value_text("automaton").value
    path = document.path.parent / name
    text = automaton_text(path, document.span("automaton"), name)
    return from_hoa(text, document.keys("propositions") or None, file=path.as_posix())


def automaton_text(path: Path, span: Span | None = None, name: str = "") -> str:
    """The text of the HOA file `path`. Raises CompileError SPEC105, at `span`."""
    try:
        return path.read_bytes().decode()
    except (OSError, UnicodeDecodeError) as error:
        problem = "not UTF-8 text" if isinstance(error, ValueError) else str(error.strerror)
        shown = name or path.as_posix()
        problem = problem[:1].lower() + problem[1:]
        raise CompileError(Diagnostic.of("SPEC105", span, path=shown, problem=problem)) from None


def import_findings(ldba: Ldba, document: Document) -> Iterator[Diagnostic]:
    """AUT301, AUT308 and AUT309: what is no fault of the file but should be known."""
    span = document.span("automaton")
    read = 0
    for edge in ldba.edges:
        for cube in edge.guard:
            read |= cube.mask
    for bit, name in enumerate(document.keys("propositions")):
        if not read >> bit & 1:
            place = document.key_span("propositions", name)
            yield Diagnostic.of("AUT308", place, name=name, help="remove it, or use it")
    if is_empty(ldba):
        return
    if _accepts_everything(ldba):
        yield Diagnostic.of("AUT309", span)
    elif ldba.jumps:
        yield Diagnostic.of("AUT301", span, problem="the agent chooses when to take them")


def _accepts_everything(ldba: Ldba) -> bool:
    """Whether no word is rejected; False where that would take too long to say."""
    try:
        word = rejected_word(ldba, max_states=UNIVERSAL_STATES, timeout=UNIVERSAL_SECONDS)
    except CompileError:
        return False
    return word is None
