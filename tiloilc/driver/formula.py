"""What can be said about a formula before any training: the automaton, and findings on meaning."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tiloilc.automaton import is_empty, translate
from tiloilc.automaton.language.compare import irrelevant_propositions
from tiloilc.automaton.language.questions import is_satisfiable, small_budget
from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.driver.vacuity import irrelevant_parts
from tiloilc.ltl import Parsed, Syntax, propositions_of, to_text
from tiloilc.ltl.ast import Always, And, Eventually, Formula, Next, Not


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
    """LTL210 to LTL213, LTL215 and AUT301; at `span` where they are about the whole formula."""
    if is_empty(ldba):
        yield Diagnostic.of("LTL210", span)
        return
    if is_tautology(parsed.formula):
        yield Diagnostic.of("LTL211", span)
        return
    yield from _vacuous(parsed)
    for part in chains(parsed.syntax):
        place = parsed.text.span(part.start, part.end)
        yield Diagnostic.of("LTL215", place, part=to_text(part.formula))
    if ldba.jumps:
        yield Diagnostic.of("AUT301", span, problem="the agent chooses when to take them")


def is_tautology(formula: Formula) -> bool:
    """Whether every word satisfies `formula`; False where that would take too long to say."""
    try:
        return not is_satisfiable(Not(formula), propositions_of(formula), small_budget())
    except CompileError:
        return False


def chains(syntax: Syntax) -> Iterator[Syntax]:
    """The parts `GF(a & XF(b & …))`, whose order their language does not have."""
    waiting = [syntax]
    while waiting:
        part = waiting.pop()
        waiting.extend(reversed(part.parts))
        match part.formula:
            case Always(Eventually(And(operands))) if any(map(_continues, operands)):
                yield part


def _continues(part: Formula) -> bool:
    """Whether `part` is `XF …`."""
    return isinstance(part, Next) and isinstance(part.operand, Eventually)


def _vacuous(parsed: Parsed) -> Iterator[Diagnostic]:
    """LTL212 for parts that do not matter, LTL213 for propositions of which no part says so."""
    told: set[Span] = set()
    help = "remove it, or check what was meant"
    for part, _ in irrelevant_parts(parsed.syntax, parsed.propositions):
        span = parsed.text.span(part.start, part.end)
        yield Diagnostic.of("LTL212", span, part=to_text(part.formula), help=help)
        told |= {place for _, place in parsed.occurrences if _within(place, span)}
    for name in irrelevant_propositions(parsed.formula, parsed.propositions):
        places = [place for written, place in parsed.occurrences if written == name]
        if not told.issuperset(places):
            yield Diagnostic.of("LTL213", places[0], name=name, help=help)


def _within(inner: Span, outer: Span) -> bool:
    begin, end = (inner.line, inner.column), (inner.end_line, inner.end_column)
    return (outer.line, outer.column) <= begin and end <= (outer.end_line, outer.end_column)


def _placed(diagnostic: Diagnostic, span: Span) -> Diagnostic:
    return replace(diagnostic, span=diagnostic.span or span)
