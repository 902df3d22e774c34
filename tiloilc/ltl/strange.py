"""LTL201 for stretches of a text that begin no token, with what was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterator

from tiloilc.diag import Diagnostic, SourceText
from tiloilc.ltl.lexer import QUOTED, SINGLE_QUOTED, Lexed, Token

COMPARISON = "comparisons belong into the definition of a proposition"
EQUALITY = "equality of truth values is `<->`"
QUOTES = 'a proposition is quoted by `"`'
GROUPS = "formulas are grouped by `(` and `)`"
COMMENTS = "comments are written `/* … */`"
BOUNDS = "bounds follow X, F or G: `X[3]`, `F[2:5]`, `G[2:]`"

HELP = {
    "!=": "inequality of truth values is `^`",
    "<-": "implication is `->`",
    ":=": EQUALITY,
    "=": EQUALITY,
    "<": COMPARISON,
    ">": COMPARISON,
    "-": "implication is `->`, negation is `!`",
    "'": QUOTES,
    "`": QUOTES,
    "{": GROUPS,
    "[": GROUPS,
    "/": COMMENTS,
    "#": COMMENTS,
    ",": "conjunction is `&`",
    "\\": "disjunction is `\\/` or `|`, conjunction `/\\` or `&`",
}
"""What was probably meant by what the language does not have, by its first one or two signs."""

PAIRS = {"}": "{", "]": "[", "`": "`", "'": "'"}
"""Closing signs that are not worth a finding of their own after the opening one."""

TEMPORAL = {"NEXT": "X", "EVENTUALLY": "F", "ALWAYS": "G"}
_RANGE = re.compile(r"\[\s*(\d+)?\s*(:|\.\.|,|to)?\s*(\d+)?\s*!?\s*\]")


def strange_findings(text: SourceText, lexed: Lexed) -> Iterator[Diagnostic]:
    """A finding for each strange stretch, but not for what only follows from the one before."""
    opened: set[str] = set()
    last = -1
    ending = {token.end: token for token in lexed.tokens}
    for start, end in lexed.strange:
        stretch = text.value[start:end]
        follows = last >= 0 and not text.value[last:start].strip()
        last = end
        if follows or PAIRS.get(stretch[0]) in opened:
            continue
        opened.add(stretch[0])
        yield _finding(text, start, end, ending.get(start))


def _finding(text: SourceText, start: int, end: int, before: Token | None) -> Diagnostic:
    stretch = text.value[start:end]
    span = text.span(start, end)
    if QUOTED.fullmatch(stretch) or SINGLE_QUOTED.fullmatch(stretch):
        problem, label = "expected a name between the quotes", "empty"
        if len(stretch) > 2:
            problem, label = "expected a name that can be printed", "has other characters"
        return Diagnostic.of("LTL201", span, problem=problem, label=label)
    if stretch.startswith(('"', "/*")):
        closing = '"' if stretch[0] == '"' else "*/"
        return Diagnostic.of(
            "LTL201",
            text.span(start, start + len(closing)),
            problem=f"expected a closing `{closing}` before the end of the formula",
            label="never closed",
        )
    if stretch[0].isdigit():
        return Diagnostic.of(
            "LTL201",
            span,
            problem=f"expected a proposition, found `{stretch}`",
            label="a name does not begin with a digit",
            help=f'quote the proposition: `"{stretch}"`',
        )
    if stretch == "[" and before is not None and before.kind in TEMPORAL:
        problem = f"expected bounds and `]` after `{_shown(text, before)}[`"
        return Diagnostic.of("LTL201", span, problem=problem, label="never closed", help=BOUNDS)
    if stretch.startswith("[") and before is not None:
        return Diagnostic.of(
            "LTL201",
            span,
            problem=f"expected a formula or bounds after `{_shown(text, before)}`, "
            f"found `{stretch}`"
            if before.kind in TEMPORAL
            else f"expected an operator or a proposition, found `{stretch}`",
            label="not bounds" if before.kind in TEMPORAL else "not part of the formula language",
            help=_about_bounds(stretch, before),
        )
    shown = f"`{stretch}`" if stretch.isprintable() else f"`{ascii(stretch)[1:-1]}`"
    help = HELP.get(stretch[:2], HELP.get(stretch[0], ""))
    return Diagnostic.of(
        "LTL201",
        span,
        problem=f"expected an operator or a proposition, found "
        f"{'a backquote' if stretch[0] == '`' else shown}",
        label="not part of the formula language",
        help=help if stretch.isprintable() else "remove this character, which cannot be seen",
    )


def _shown(text: SourceText, token: Token) -> str:
    return text.value[token.start : token.end]


def _about_bounds(stretch: str, before: Token) -> str:
    """What is wrong with bounds, or that there cannot be any."""
    operator = TEMPORAL.get(before.kind)
    if before.kind in ("NAME", "CLOSE"):
        return "a proposition has no index; its definition may use `pos[0]`"
    if operator is None:
        return GROUPS if before.kind == "OPEN" else BOUNDS
    found = _RANGE.fullmatch(stretch)
    if found is None:
        return BOUNDS
    first, to, last = found.groups()
    if operator == "X":
        return "X takes one number: `X[3]`"
    if to is None and first is not None:
        return f"{operator} takes two bounds: `{operator}[0:{first}]` or `{operator}[{first}:]`"
    if first and last and int(first) > int(last):
        return "the first bound must not be greater than the second"
    return BOUNDS
