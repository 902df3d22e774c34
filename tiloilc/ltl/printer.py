"""Formula to text that Spot and `parse` read back, with as few or as many brackets as wanted."""

from __future__ import annotations

from tiloilc.ltl.ast import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Iff,
    Implies,
    Next,
    Not,
    Or,
    Proposition,
    Release,
    StrongRelease,
    Until,
    WeakUntil,
    Xor,
    subformulas,
)
from tiloilc.ltl.lexer import is_plain_name

PREFIX = {Not: "!", Next: "X ", Eventually: "F ", Always: "G "}

ARROW, EITHER, EXCLUSIVE, BOTH, UNTIL, UNARY, ATOM = range(1, 8)
"""How tightly an operator binds, loosest first (the table in `ltl.lark`)."""

INFIX: dict[type[Formula], tuple[str, int, int, int]] = {
    Implies: ("->", ARROW, EITHER, ARROW),
    Iff: ("<->", ARROW, EITHER, ARROW),
    Or: ("|", EITHER, EXCLUSIVE, EXCLUSIVE),
    Xor: ("^", EXCLUSIVE, EXCLUSIVE, BOTH),
    And: ("&", BOTH, UNTIL, UNTIL),
    Until: ("U", UNTIL, UNARY, UNTIL),
    WeakUntil: ("W", UNTIL, UNARY, UNTIL),
    Release: ("R", UNTIL, UNARY, UNTIL),
    StrongRelease: ("M", UNTIL, UNARY, UNTIL),
}
"""Sign, own level, and the levels that the first and the other operands need to go unbracketed."""


def to_text(formula: Formula, *, brackets: bool = False) -> str:
    """`formula` as text that reads back as the same formula, in Spot's syntax.

    Brackets stand where they are needed, and where operators of one level are mixed.
    With `brackets` every operand of a binary operator that is not a single name has them, so that
    nothing is left to precedence.
    """
    texts: dict[Formula, tuple[str, int]] = {}
    for part in subformulas(formula):
        texts[part] = _text(part, [texts[child] for child in part.children], brackets)
    return texts[formula][0]


def _text(part: Formula, operands: list[tuple[str, int]], brackets: bool) -> tuple[str, int]:
    """Text and level of `part` over those of its operands."""
    match part:
        case Constant(value):
            return ("true" if value else "false"), ATOM
        case Proposition(name):
            return name_text(name), ATOM
        case Not() | Next() | Eventually() | Always():
            return PREFIX[type(part)] + _bracketed(*operands[0], UNARY), UNARY
    sign, level, first, rest = INFIX[type(part)]
    if brackets:
        first = rest = ATOM
    assert len(operands) > 1, "a conjunction or disjunction has two or more operands"
    texts = [_bracketed(*operands[0], first)]
    for child, (text, own) in zip(part.children[1:], operands[1:], strict=True):
        mixed = own == level and type(child) is not type(part)
        texts.append(_bracketed(text, own, level + 1 if mixed else rest))
    return f" {sign} ".join(texts), level


def _bracketed(text: str, level: int, needed: int) -> str:
    return text if level >= needed else f"({text})"


def name_text(name: str) -> str:
    """A proposition's name, quoted if it could be read as anything else."""
    if is_plain_name(name):
        return name
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
