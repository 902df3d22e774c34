"""Checked pieces of a predicate, the operators that make them, and how the tree is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from lark import Token, Tree

from tiloilc.label.functions import NUMBER, Array, Kind

Run = Callable[[Array], Array]

ARITHMETIC: Mapping[str, Callable[[Array, Array], Array]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "%": lambda a, b: np.asarray(np.mod(a, b)),
    "**": lambda a, b: np.asarray(np.power(a, b)),
}
COMPARISON: Mapping[str, Callable[[Array, Array], Array]] = {
    "<": np.less,
    "<=": np.less_equal,
    "≤": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "≥": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
    "≠": np.not_equal,
}


@dataclass(frozen=True, slots=True)
class Expression:
    """A checked piece: observations [..., d] to values (see `functions`). `kind` None: wrong."""

    kind: Kind | None
    run: Run


def _nothing(observations: Array) -> Array:
    raise AssertionError("a predicate with findings is never run")


WRONG = Expression(None, _nothing)
"""Stands for what has been found wrong already, so that one mistake is one finding."""


def constant(value: float) -> Expression:
    """The same number for every observation."""
    array = np.asarray(value, dtype=np.float64)
    return Expression(NUMBER, lambda observations: array)


def trees_of(node: Tree[Token]) -> list[Tree[Token]]:
    """The children that are trees, in order."""
    return [child for child in node.children if isinstance(child, Tree)]


def as_token(child: Token | Tree[Token]) -> Token:
    """The child, which the grammar makes a token."""
    assert isinstance(child, Token), "the grammar says so"
    return child


def extent(node: Tree[Token] | Token) -> tuple[int, int]:
    """Start and end of a piece in the predicate's text."""
    if isinstance(node, Token):
        return node.start_pos or 0, node.end_pos or 0
    return node.meta.start_pos, node.meta.end_pos


def whole_number(node: Tree[Token]) -> int | None:
    """A whole number that is written out, with or without a sign."""
    if node.data == "signed":
        sign, operand = node.children
        inner = whole_number(operand) if isinstance(operand, Tree) else None
        return inner if inner is None or sign == "+" else -inner
    digits = str(node.children[0]) if node.data == "number" else ""
    return int(digits) if digits.isdigit() and len(digits) < 10 else None
