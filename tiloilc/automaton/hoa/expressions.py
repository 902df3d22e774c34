"""Labels and acceptance conditions: `!`, `&`, `|` and brackets, at any depth, without recursion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, Literal, NamedTuple, TypeVar

from tiloilc.automaton.bdd import FALSE, TRUE, Diagrams, Node
from tiloilc.automaton.hoa.tokens import Token, Tokens
from tiloilc.automaton.limits import too_large

T = TypeVar("T")

Operator = Literal["!", "&", "|"]

_BINDING = {"!": 3, "&": 2, "|": 1}


class Atom(NamedTuple, Generic[T]):
    """What stands between the operators, and its word."""

    value: T
    token: Token


Postfix = list[Atom[T] | Operator]
"""An expression with its operators behind their operands."""


def postfix(tokens: Tokens, atom: Callable[[Tokens], Atom[T]], *, negation: bool) -> Postfix[T]:
    """Read an expression as far as it goes. Raises CompileError AUT302.

    `atom` reads one operand; `negation` says whether `!` may stand before operands.
    """
    output: Postfix[T] = []
    waiting: list[Token] = []
    depth = 0
    while True:
        while tokens.at("(") or (negation and tokens.at("!")):
            depth += tokens.at("(")
            waiting.append(tokens.take())
        output.append(atom(tokens))
        _settle(output, waiting, _BINDING["!"])
        while depth and tokens.at(")"):
            _settle(output, waiting, 0)
            waiting.pop()
            tokens.take()
            depth -= 1
            _settle(output, waiting, _BINDING["!"])
        if not tokens.at("&", "|"):
            break
        _settle(output, waiting, _BINDING[tokens.next.text])
        waiting.append(tokens.take())
    if depth:
        raise tokens.unexpected("`&`, `|` or `)`")
    _settle(output, waiting, 0)
    return output


def _settle(output: Postfix[T], waiting: list[Token], binding: int) -> None:
    """Move operators that bind at least so tightly behind their operands, up to a bracket."""
    while waiting and waiting[-1].text != "(" and _BINDING[waiting[-1].text] >= binding:
        output.append(waiting.pop().text)  # type: ignore[arg-type]  # an operator


def label_atom(tokens: Tokens) -> Atom[str]:
    """A proposition's number, an alias, `t` or `f`."""
    if tokens.next.kind == "int":
        return Atom("", tokens.number("a label")[1])
    if tokens.next.kind == "alias" or tokens.next.text in ("t", "f"):
        return Atom("", tokens.take())
    raise tokens.unexpected("the number of a proposition, `@alias`, `t`, `f`, `!` or `(`")


def label_node(label: Postfix[str], diagrams: Diagrams, value: Callable[[Token], Node]) -> Node:
    """The letters of a label; `value` gives those of each operand."""
    stack: list[Node] = []
    for item in label:
        diagrams.budget.tick()
        if isinstance(item, Atom):
            text = item.token.text
            stack.append(TRUE if text == "t" else FALSE if text == "f" else value(item.token))
        elif item == "!":
            stack.append(diagrams.negate(stack.pop()))
        else:
            right, left = stack.pop(), stack.pop()
            stack.append(diagrams.conj(left, right) if item == "&" else diagrams.disj(left, right))
    (node,) = stack
    return node


class Visited(NamedTuple):
    """`Inf(n)`, or with `outside` `Inf(!n)`: edges in set n, or edges outside it, for ever."""

    number: int
    outside: bool


class Condition(NamedTuple):
    """One operand of an acceptance condition: `Inf(…)`, `Fin(…)`, `t` or `f`."""

    name: str
    visited: Visited


Clause = frozenset[Visited]
"""One of these must be visited infinitely often. The empty clause: never."""

MAX_CLAUSES = 64
"""Sets of generalised Büchi acceptance: each multiplies the accepting states."""


MAX_OPERANDS = 1_000
"""Operands and operators of an acceptance condition; tools write a few dozen."""


def condition_atom(tokens: Tokens) -> Atom[Condition]:
    """`Inf(0)`, `Inf(!0)`, the same with `Fin`, `t` or `f`."""
    if tokens.next.text not in ("Inf", "Fin", "t", "f"):
        raise tokens.unexpected("`Inf(…)`, `Fin(…)`, `t`, `f` or `(`")
    token = tokens.take()
    if token.text in ("t", "f"):
        return Atom(Condition(token.text, Visited(0, False)), token)
    tokens.expect("sign", f"`(` after `{token.text}`", "(")
    outside = tokens.at("!")
    if outside:
        tokens.take()
    number, at = tokens.number("the number of an acceptance set")
    tokens.expect("sign", "`)`", ")")
    return Atom(Condition(token.text, Visited(number, outside)), at)


def clauses(condition: Sequence[Atom[Condition] | Operator]) -> tuple[Clause, ...]:
    """A condition without `Fin` as sets of edges, all to be visited infinitely often.

    Büchi conditions are closed under disjunction, so `Inf(0) | Inf(1)` is one set. `t` is no set
    at all, `f` an empty one. Raises CompileError AUT305 for too many sets.
    """
    stack: list[tuple[Clause, ...]] = []
    if len(condition) > MAX_OPERANDS:
        raise too_large(f"its acceptance has more than {MAX_OPERANDS:_} parts")
    for item in condition:
        if isinstance(item, Atom):
            name, visited = item.value
            assert name != "Fin", "refused before"
            stack.append(() if name == "t" else (frozenset({visited} if name == "Inf" else ()),))
        else:
            right, left = stack.pop(), stack.pop()
            joined = left + right if item == "&" else [a | b for a in left for b in right]
            stack.append(_irredundant(joined))
    (result,) = stack
    return result


def _irredundant(found: Sequence[Clause]) -> tuple[Clause, ...]:
    """Without clauses that say nothing, or less than another."""
    said = [c for c in dict.fromkeys(found) if not any((n, not o) in c for n, o in c)]
    kept = [c for c in said if not any(other < c for other in said)]
    if len(kept) > MAX_CLAUSES:
        raise too_large(f"its acceptance needs more than {MAX_CLAUSES} sets")
    return tuple(kept)
