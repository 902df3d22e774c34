"""Formula text to formula, with every finding about the text: the front door of the package."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import islice

from tiloilc.diag import CompileError, Diagnostic, SourceText, Span
from tiloilc.ltl.ast import Formula
from tiloilc.ltl.lexer import Ambiguity, Lexed, Token, tokenize
from tiloilc.ltl.precedence import surprises
from tiloilc.ltl.strange import strange_findings
from tiloilc.ltl.syntax import Stop, Syntax, read_syntax

MAX_LENGTH = 100_000
"""Characters. A longer text is no formula that anyone wrote, or could translate."""

MAX_FINDINGS = 50
"""Of one kind. Nobody reads more, and of a long text without sense there would be thousands."""


@dataclass(frozen=True, slots=True)
class Parsed:
    """A formula, how it was read from the text, and where its propositions stand there.

    `propositions` are all that were declared, or those that appear, in this order.
    """

    formula: Formula
    text: SourceText
    syntax: Syntax
    warnings: tuple[Diagnostic, ...]
    occurrences: tuple[tuple[str, Span], ...]
    propositions: tuple[str, ...]


def parse(text: SourceText | str, propositions: Sequence[str] | None = None) -> Parsed:
    """Read a formula over the declared `propositions` (None: any identifier is one).

    Raises CompileError with all findings: LTL201 for text that is no formula, LTL202 for too much
    of it, LTL203 for each name that is not declared.
    """
    if isinstance(text, str):
        text = SourceText.plain(text)
    if len(text.value) > MAX_LENGTH:
        problem = f"{len(text.value)} characters, {MAX_LENGTH} are the limit"
        raise CompileError(Diagnostic.of("LTL202", text.span(0, 1), problem=problem))
    lexed = tokenize(text.value, propositions)
    names = [token for token in lexed.tokens if token.kind == "NAME"]
    findings = list(islice(strange_findings(text, lexed), MAX_FINDINGS))
    tree = None if findings else read_syntax(text, lexed.tokens)
    if isinstance(tree, Stop):
        findings.append(tree.diagnostic)
        names = [t for t in names if t.end <= tree.start or t.start >= tree.end]
    if propositions is not None:
        known = set(propositions)
        unknown = [token for token in names if token.name not in known][:MAX_FINDINGS]
        findings += [_unknown(text, token, propositions) for token in unknown]
    if findings:
        raise CompileError(*sorted(findings, key=Diagnostic.sort_key))
    assert tree is not None
    assert not isinstance(tree, Stop)
    seen = tuple(dict.fromkeys(token.name for token in names))
    return Parsed(
        formula=tree.formula,
        text=text,
        syntax=tree,
        warnings=_warnings(text, lexed, [*surprises(text, tree)]),
        occurrences=tuple((token.name, text.span(token.start, token.end)) for token in names),
        propositions=seen if propositions is None else tuple(propositions),
    )


def _warnings(
    text: SourceText, lexed: Lexed, surprising: list[Diagnostic]
) -> tuple[Diagnostic, ...]:
    both = surprising + [_ambiguous(text, word) for word in lexed.ambiguous]
    return tuple(sorted(both, key=Diagnostic.sort_key))


def _unknown(text: SourceText, token: Token, declared: Sequence[str]) -> Diagnostic:
    """LTL203, with what was probably meant."""
    known = ", ".join(declared) if declared else "none"
    help = f"declared: {known}"
    if spaced := _spaced(token.name, declared):
        help = f"did you mean `{spaced}`? {help}"
    elif close := _closest(token.name, declared):
        help = f"did you mean `{close}`? {help}"
    return Diagnostic.of(
        "LTL203",
        text.span(token.start, token.end),
        name=token.name,
        label="not declared",
        help=help,
    )


def _closest(name: str, declared: Sequence[str]) -> str | None:
    folded = {other.casefold(): other for other in reversed(declared)}
    start = name.casefold()[:80]
    close = get_close_matches(start, list(folded), n=1, cutoff=0.6)
    longer = [other for other in folded if other.startswith(start) and len(start) > 1]
    return folded[close[0]] if close else folded[longer[0]] if len(longer) == 1 else None


def _spaced(name: str, declared: Sequence[str]) -> str | None:
    """`aUb` as `a U b`, if a and b are declared."""
    for place, letter in enumerate(name[:80]):
        left, right = name[:place], name[place + 1 :]
        if letter in "URWMV" and left in declared and right in declared:
            return f"{left} {letter} {right}"
    return None


def _ambiguous(text: SourceText, word: Ambiguity) -> Diagnostic:
    reading = (
        f"the proposition `{word.name}`, not as `{word.otherwise}`"
        if word.otherwise != word.name
        else "the declared proposition, not as the operator or constant"
    )
    return Diagnostic.of(
        "LTL205",
        text.span(word.start, word.end),
        word=word.name,
        reading=reading,
        label="a proposition",
        help=f'write `"{word.name}"` for the proposition'
        + (f", `{word.otherwise}` for the other" if word.otherwise != word.name else ""),
    )
