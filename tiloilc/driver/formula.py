"""What can be said about a formula before any training: the automaton, and findings on meaning."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tiloilc.automaton import is_empty, satisfying_word, translate
from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.driver.vacuity import irrelevant_parts
from tiloilc.ltl import Parsed, propositions_of, subformulas, to_text
from tiloilc.ltl.ast import Always, And, Eventually, Formula, Next, Not, Proposition

TAUTOLOGY_STATES = 500
TAUTOLOGY_SECONDS = 2.0
"""Beyond these nobody asks whether a formula is always true: it is not written that large."""


def translated(parsed: Parsed, span: Span) -> Ldba:
    """The automaton of a formula. Raises CompileError AUT305, at `span`."""
    try:
        return translate(parsed.formula, parsed.propositions)
    except CompileError as error:
        raise CompileError(*(_placed(d, span) for d in error.diagnostics)) from None


def unused(parsed: Parsed, spans: Sequence[Span]) -> Iterator[Diagnostic]:
    """LTL204 for each declared proposition that the formula never names; `spans` are theirs."""
    used = {name for name, _ in parsed.occurrences}
    for name, span in zip(parsed.propositions, spans, strict=True):
        if name not in used:
            yield Diagnostic.of("LTL204", span, name=name, help="remove it, or use it")


def meaning(parsed: Parsed, ldba: Ldba, span: Span) -> Iterator[Diagnostic]:
    """LTL210 to LTL212, LTL215 and AUT301; at `span` where they are about the whole formula."""
    if is_empty(ldba):
        yield Diagnostic.of("LTL210", span)
        return
    if is_tautology(parsed.formula):
        yield Diagnostic.of("LTL211", span)
        return
    for part in irrelevant_parts(parsed.formula, parsed.propositions):
        help = "remove it, or check what was meant"
        yield Diagnostic.of("LTL212", _place(part, parsed) or span, part=to_text(part), help=help)
    for part in chains(parsed.formula):
        yield Diagnostic.of("LTL215", _place(part, parsed) or span, part=to_text(part))
    if ldba.jumps:
        yield Diagnostic.of("AUT301", span, problem="the agent chooses when to take them")


def is_tautology(formula: Formula) -> bool:
    """Whether every word satisfies `formula`; False where that would take too long to say."""
    try:
        refuting = satisfying_word(
            Not(formula),
            propositions_of(formula),
            max_states=TAUTOLOGY_STATES,
            timeout=TAUTOLOGY_SECONDS,
        )
    except CompileError:
        return False
    return refuting is None


def chains(formula: Formula) -> Iterator[Formula]:
    """The sub-formulas `GF(a & XF(b & …))`, whose order their language does not have."""
    for part in subformulas(formula):
        match part:
            case Always(Eventually(And(operands))) if any(map(_continues, operands)):
                yield part


def _continues(part: Formula) -> bool:
    """Whether `part` is `XF …`."""
    return isinstance(part, Next) and isinstance(part.operand, Eventually)


def _place(part: Formula, parsed: Parsed) -> Span | None:
    """From the first to the last proposition of `part`, where they stand like this in the text."""
    names: list[str] = []
    waiting = [part]
    while waiting:
        node = waiting.pop()
        if isinstance(node, Proposition):
            names.append(node.name)
        waiting.extend(reversed(node.children))
    written = [name for name, _ in parsed.occurrences]
    for i in range(len(written) - len(names) + 1):
        if names and written[i : i + len(names)] == names:
            first, last = parsed.occurrences[i][1], parsed.occurrences[i + len(names) - 1][1]
            return replace(first, end_line=last.end_line, end_column=last.end_column)
    return None


def _placed(diagnostic: Diagnostic, span: Span) -> Diagnostic:
    return replace(diagnostic, span=diagnostic.span or span)
