"""An automaton that the task file names instead of a formula, and what can be said about it."""

from __future__ import annotations

from collections.abc import Iterator

from tiloilc.automaton import is_empty, load_hoa, rejected_word
from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.spec import Document

UNIVERSAL_STATES = 2_000
UNIVERSAL_SECONDS = 2.0
"""Beyond these nobody asks whether an automaton accepts everything."""


def imported(document: Document) -> Ldba:
    """The automaton in the file that `automaton:` names, over the declared propositions.

    Raises CompileError SPEC105 if the file cannot be read, and AUT302 to AUT307.
    """
    path = document.path.parent / document.value_text("automaton").value
    declared = document.keys("propositions") or None
    return load_hoa(path, declared, span=document.span("automaton")).ldba


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
