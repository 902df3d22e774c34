"""Tokens to a syntax tree: lark's LALR tables over `ltl.lark`, and what to say when they stop."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from tiloilc.diag import Diagnostic, SourceText
from tiloilc.ltl.ast import (
    FALSE,
    TRUE,
    Always,
    And,
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
)
from tiloilc.ltl.lexer import BINARY_KINDS, WORD_KINDS, Token

if TYPE_CHECKING:
    import lark

MAX_DEPTH = 200
"""Operators inside operators. Later passes recurse, and Python stops at 1000 calls."""


@dataclass(frozen=True, slots=True)
class Syntax:
    """A part of the text as it was read: `text[start:end]` means `formula`.

    `rule` names its operator, `bounds` are those of F[2:5] and the like; brackets around it are
    counted in the stretch and in `bracketed`.
    """

    rule: str
    formula: Formula
    start: int
    end: int
    depth: int = 0
    parts: tuple[Syntax, ...] = ()
    bracketed: bool = False
    bounds: str = ""

    def over(self, operands: Sequence[Formula]) -> Formula:
        """The operator of this part over other operands."""
        if self.rule == "bounded":
            return _bounded(self.bounds, operands[0], 0)[0]
        return OPERATORS[self.rule](*operands)


@dataclass(frozen=True, slots=True)
class Stop:
    """Why the text is not a formula: the finding, and the stretch that it is about."""

    diagnostic: Diagnostic
    start: int
    end: int


def read_syntax(text: SourceText, tokens: list[Token]) -> Syntax | Stop:
    """The syntax tree of `tokens`, or why there is none."""
    from lark import Token as Terminal
    from lark import UnexpectedToken

    state = _grammar().parse_interactive("")
    tree: object = None
    for place, token in enumerate([*tokens, Token("$END", len(text.value), len(text.value))]):
        terminal = Terminal(token.kind, token.name, start_pos=token.start, end_pos=token.end)
        try:
            tree = state.feed_token(terminal)
        except UnexpectedToken as error:
            return _stop(text, tokens, place, "NAME" in error.expected)
    assert isinstance(tree, Syntax)
    return tree if tree.depth <= MAX_DEPTH else _too_deep(text, tree)


@cache
def _grammar() -> lark.Lark:
    """The LALR tables, made once: 10 ms."""
    import lark
    from lark.lexer import Lexer

    class NoLexer(Lexer):
        """Tokens are fed one by one."""

        def __init__(self, _: object) -> None: ...

        def lex(self, *_: object) -> Iterator[lark.Token]:
            return iter(())

    class Builder(lark.Transformer[lark.Token, Syntax]):
        """Builds every rule by `_built`."""

        def __getattr__(self, rule: str) -> Callable[[list[Syntax | lark.Token]], Syntax]:
            if rule not in RULES:
                raise AttributeError(rule)
            return lambda children: _built(rule, children)

    grammar = files("tiloilc.ltl").joinpath("ltl.lark").read_text(encoding="utf-8")
    return lark.Lark(grammar, parser="lalr", lexer=NoLexer, transformer=Builder())


RULES = frozenset(
    {"start", "brackets", "proposition", "denied", "true", "false", "implies", "iff", "either"}
    | {"xor", "both", "until", "weak", "release", "strong", "negate", "next", "eventually"}
    | {"always", "bounded"}
)
"""The rules of the grammar."""

OPERATORS: dict[str, Callable[..., Formula]] = {
    "implies": Implies,
    "iff": Iff,
    "either": lambda *operands: Or(operands),
    "xor": Xor,
    "both": lambda *operands: And(operands),
    "until": Until,
    "weak": WeakUntil,
    "release": Release,
    "strong": StrongRelease,
    "negate": Not,
    "next": Next,
    "eventually": Eventually,
    "always": Always,
}
"""What the rules of the grammar build."""


def _built(rule: str, children: list[Syntax | lark.Token]) -> Syntax:
    """The syntax of one rule of the grammar over its tokens and parts."""
    parts = tuple(child for child in children if isinstance(child, Syntax))
    start, end = _start(children[0]), _end(children[-1])
    if rule == "start":
        return parts[0]
    if rule == "brackets":
        return replace(parts[0], start=start, end=end, bracketed=True)
    if not parts:
        name = str(children[0])
        leaf: dict[str, Formula] = {"true": TRUE, "false": FALSE, "proposition": Proposition(name)}
        if rule == "denied":
            return Syntax("negate", Not(Proposition(name)), start, end, 1)
        return Syntax(rule, leaf[rule], start, end)
    if rule == "bounded":
        bounds = str(children[0])
        formula, depth = _bounded(bounds, parts[0].formula, parts[0].depth)
        return Syntax(rule, formula, start, end, depth, parts, bounds=bounds)
    formula = OPERATORS[rule](*(part.formula for part in parts))
    return Syntax(rule, formula, start, end, 1 + max(part.depth for part in parts), parts)


def _bounded(operator: str, part: Formula, depth: int) -> tuple[Formula, int]:
    """`F[2:4] a` as `X X (a | X (a | X a))`, and how deep that is if `part` is `depth` deep.

    Bounds beyond the depth limit are not written out: the depth says that there is an error.
    """
    kind, first, *last = operator.split()
    delay, choices = int(first), max(0, int(last[0]) - int(first)) if last else 0
    opened = kind != "NEXT" and not last
    depth += delay + 2 * choices + opened
    formula = part
    if depth > MAX_DEPTH:
        return formula, depth
    if opened:
        formula = Eventually(formula) if kind == "EVENTUALLY" else Always(formula)
    for _ in range(choices):
        both = (part, Next(formula))
        formula = Or(both) if kind == "EVENTUALLY" else And(both)
    for _ in range(delay):
        formula = Next(formula)
    return formula, depth


def _start(child: Syntax | lark.Token) -> int:
    start = child.start if isinstance(child, Syntax) else child.start_pos
    assert start is not None
    return start


def _end(child: Syntax | lark.Token) -> int:
    end = child.end if isinstance(child, Syntax) else child.end_pos
    assert end is not None
    return end


def _too_deep(text: SourceText, tree: Syntax) -> Stop:
    while deep := [part for part in tree.parts if part.depth > MAX_DEPTH]:
        tree = deep[0]
    finding = Diagnostic.of(
        "LTL202",
        text.span(tree.start, tree.start + 1),
        problem=f"operators are nested more than {MAX_DEPTH} deep",
        label="from here inwards",
    )
    return Stop(finding, tree.start, tree.end)


OPERATOR_EXAMPLES = "`&`, `|`, `->` or `U`"
OPERAND_NAMES = "a proposition, `true`, `(` or an operator such as `!`, `F` or `G`"


def _stop(text: SourceText, tokens: list[Token], place: int, wants_formula: bool) -> Stop:
    """What to say at token `place` (the end, if there is no such token)."""

    def shown(token: Token) -> str:
        return f"`{text.value[token.start : token.end]}`"

    def at(token: Token, problem: str, label: str, help: str = "") -> Stop:
        span = text.span(token.start, token.end)
        finding = Diagnostic.of("LTL201", span, problem=problem, label=label, help=help)
        return Stop(finding, token.start, token.end)

    before = tokens[place - 1] if place else None
    found = tokens[place] if place < len(tokens) else None
    if before is None and found is None:
        whole = Token("NAME", 0, max(1, len(text.value)))
        return at(whole, "expected a formula, found nothing", "empty")
    if wants_formula:
        if before is not None and shown(before) == "`()`":  # `next`, but hardly meant so
            return at(before, "expected a formula between `(` and `)`", "empty brackets")
        if found is None:
            assert before is not None
            return at(before, f"expected a formula after {shown(before)}", "nothing follows")
        if found.kind == "CLOSE" and before is not None and before.kind == "OPEN":
            both = Token("OPEN", before.start, found.end)
            return at(both, "expected a formula between `(` and `)`", "empty brackets")
        where = f" after {shown(before)}" if before is not None else ""
        help = _help_for_missing_operand(text, before, found)
        problem = f"expected a formula{where}, found {shown(found)}"
        return at(found, problem, f"expected {OPERAND_NAMES}", help)
    assert before is not None
    if found is None:
        unclosed = _unclosed(tokens)
        return at(unclosed, "expected `)` before the end of the formula", "never closed")
    if found.kind == "CLOSE":
        problem = "expected an operator or the end of the formula, found `)`"
        return at(found, problem, "closes no bracket")
    problem = f"expected an operator after {shown(before)}, found {shown(found)}"
    return at(found, problem, f"expected {OPERATOR_EXAMPLES} before this")


def _unclosed(tokens: list[Token]) -> Token:
    """The innermost bracket that is still open after all `tokens`."""
    opened: list[Token] = []
    for token in tokens:
        if token.kind == "OPEN":
            opened.append(token)
        elif token.kind == "CLOSE":
            opened.pop()
    return opened[-1]


def _help_for_missing_operand(text: SourceText, before: Token | None, found: Token) -> str:
    word = text.value[found.start : found.end]
    if before is not None and before.kind == found.kind:
        return "remove one of the two operators"
    if found.kind in BINARY_KINDS and word in WORD_KINDS:
        return f'`{word}` is an operator; a proposition of this name is written `"{word}"`'
    return ""
