"""Predicate text to a tree; what does not belong to the language is said with its place."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from tiloilc.diag import CompileError, Diagnostic, SourceText

MAX_DEPTH = 64
"""Levels of brackets and operators; the deepest predicate of the paper has 5."""

_INSTEAD = {
    "=": "write `==` to compare",
    "&": "write `and`",
    "|": "write `or`",
    "!": "write `not`",
    "^": "write `**` for powers",
    "∧": "write `and`",
    "∨": "write `or`",
    "¬": "write `not`",
}
_PAIRS = {"(": ")", "[": "]"}


def parse(text: SourceText) -> Tree[Token]:
    """The tree of one predicate; every node carries the places of its text.

    Raises CompileError SPEC110 or SPEC119.
    """
    if not text.value.strip():
        raise CompileError(Diagnostic.of("SPEC110", text.span(0, 0), problem="it is empty"))
    try:
        tree = _parser().parse(text.value)
    except UnexpectedInput as error:
        raise CompileError(_finding(error, text)) from None
    _check_depth(tree, text)
    return tree


@cache
def _parser() -> Lark:
    grammar = files("tiloilc.label").joinpath("predicate.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer="basic", propagate_positions=True)


def _check_depth(tree: Tree[Token], text: SourceText) -> None:
    level: list[Tree[Token]] = [tree]
    for _ in range(MAX_DEPTH):
        level = [c for node in level for c in node.children if isinstance(c, Tree)]
        if not level:
            return
    start = level[0].meta.start_pos
    raise CompileError(Diagnostic.of("SPEC119", text.span(start, start + 1), limit=MAX_DEPTH))


def _finding(error: UnexpectedInput, text: SourceText) -> Diagnostic:
    if isinstance(error, UnexpectedCharacters):
        return _foreign(error.pos_in_stream or 0, text)
    assert isinstance(error, UnexpectedToken), "the lexer and the parser have no other complaint"
    token, wants_value = error.token, "NAME" in error.accepts
    if token.type == "$END":
        return _unfinished(text, wants_value)
    start = token.start_pos or 0
    label, help = "", ""
    written = f"`{token}`"
    if wants_value:
        problem = f"a value is missing before {written}"
        if token.type in ("AND", "OR", "NOT"):
            problem = f"{written} stands where a value is expected"
    elif token in (")", "]"):
        opened = _unclosed(text.value[:start])
        problem = f"{written} closes nothing"
        if opened is not None:
            bracket = text.value[opened]
            problem = f"`{bracket}` is closed by {written}"
            help = f"close it with `{_PAIRS[bracket]}`"
    elif token == ",":
        problem, label = "a comma has no place here", "only between arguments or components"
    else:
        problem = f"an operator is missing before {written}"
        if token.type == "NUMBER" and text.value[start - 1 : start] == ".":
            problem = f"{written} does not belong to the number before it"
    return Diagnostic.of(
        "SPEC110", text.span(start, token.end_pos), problem=problem, label=label, help=help
    )


def _foreign(start: int, text: SourceText) -> Diagnostic:
    """A character that begins nothing in the language."""
    character = text.value[start]
    doubled = text.value[start : start + 2] in ("&&", "||")
    end = start + 2 if doubled else start + 1
    problem = f"`{text.value[start:end]}` is not part of the language"
    help = _INSTEAD.get(character, "")
    if character in "\"'":
        problem = "text in quotes has no place in a predicate"
    return Diagnostic.of("SPEC110", text.span(start, end), problem=problem, help=help)


def _unfinished(text: SourceText, wants_value: bool) -> Diagnostic:
    """The text ends too early: an open bracket is its cause, or a missing value."""
    opened = _unclosed(text.value)
    if opened is not None and not wants_value:
        bracket = text.value[opened]
        return Diagnostic.of(
            "SPEC110",
            text.span(opened, opened + 1),
            problem=f"`{bracket}` is never closed",
            label="opened here",
            help=f"close it with `{_PAIRS[bracket]}`",
        )
    end = len(text.value.rstrip())
    start = max(0, end - 1)
    while start > 0 and not text.value[start - 1].isspace() and text.value[start - 1] not in "([":
        start -= 1
    return Diagnostic.of(
        "SPEC110",
        text.span(start, end),
        problem=f"a value is missing after `{text.value[start:end]}`",
        label="the text ends here",
    )


def _unclosed(value: str) -> int | None:
    """Where the innermost bracket begins that is not closed."""
    opened: list[int] = []
    for index, character in enumerate(value):
        if character in _PAIRS:
            opened.append(index)
        elif character in _PAIRS.values() and opened:
            opened.pop()
    return opened[-1] if opened else None
