"""Long and deep formulas work or end in a clear error, in every pass; no stack overflows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.running import runner
from tests.driver.specs import spec
from tiloilc.automaton import translate
from tiloilc.automaton.language.classes import formula_class
from tiloilc.automaton.language.compare import irrelevant_propositions
from tiloilc.diag import CompileError
from tiloilc.driver.vacuity import irrelevant_parts
from tiloilc.ltl import (
    Lasso,
    Parsed,
    after,
    holds,
    is_cosafety,
    is_safety,
    is_suspendable,
    negation,
    nnf,
    parse,
    simplify,
    to_text,
    unfold,
)
from tiloilc.ltl.hierarchy import syntactic_class
from tiloilc.ltl.syntax import MAX_DEPTH

BINARY = ("&", "|", "^", "->", "<->", "U", "W", "R", "M")
UNARY = ("!", "X", "F", "G")
MANY = 5_000
"""Operators of a chain or a tower."""

NAMES = ("a", "b", "c")


def chain(operator: str, count: int) -> str:
    """`a op b op c op a …` with `count` operators."""
    return f" {operator} ".join(NAMES[i % 3] for i in range(count + 1))


def nested(operator: str, count: int, right: bool) -> str:
    """`(a op (b op (…)))` or `(((…) op b) op a)` with `count` operators."""
    if right:
        return "".join(f"({NAMES[i % 3]} {operator} " for i in range(count)) + "a" + ")" * count
    return "(" * count + "a" + "".join(f" {operator} {NAMES[i % 3]})" for i in range(count))


def tried(parsed: Parsed) -> None:
    """What automata are asked; AUT305 is an answer."""
    formula, names = parsed.formula, parsed.propositions
    codes = {"AUT305"}
    try:
        formula_class(formula, translate(formula, names, max_states=50, timeout=1.0))
    except CompileError as error:
        codes = {diagnostic.code for diagnostic in error.diagnostics}
    assert codes == {"AUT305"}


PASSES: dict[str, Callable[[Parsed], object]] = {
    "to_text": lambda p: to_text(p.formula),
    "to_text with brackets": lambda p: to_text(p.formula, brackets=True),
    "nnf": lambda p: nnf(p.formula),
    "negation": lambda p: negation(p.formula),
    "simplify": lambda p: simplify(p.formula),
    "fragments": lambda p: (is_safety(p.formula), is_cosafety(p.formula)),
    "suspendable": lambda p: is_suspendable(nnf(p.formula)),
    "class": lambda p: syntactic_class(p.formula),
    "unfold": lambda p: unfold(nnf(p.formula)),
    "after": lambda p: after(nnf(p.formula), {"a"}),
    "holds": lambda p: holds(p.formula, Lasso((1,), (0, 2)), p.propositions),
    "equal": lambda p: parse(p.text).formula == p.formula,
    "vacuity": lambda p: irrelevant_parts(p.syntax, p.propositions),
    "translate": tried,
}


def run_all(text: str) -> None:
    """Every pass over a formula that can be read."""
    parsed = parse(text)
    for run in PASSES.values():
        run(parsed)


def test_ten_thousand_brackets_are_read() -> None:
    run_all("(" * 10_000 + "a" + ")" * 10_000)


@pytest.mark.parametrize("operator", BINARY)
def test_a_chain_of_thousands_works_or_is_refused(operator: str) -> None:
    text = chain(operator, MANY)
    if operator in ("&", "|"):
        run_all(text)
        return
    for deep in (text, nested(operator, MANY, True), nested(operator, MANY, False)):
        with pytest.raises(CompileError, match="LTL202") as caught:
            parse(deep)
        assert "nested more than 200 deep" in str(caught.value)


@pytest.mark.parametrize("operator", UNARY)
def test_a_tower_of_thousands_is_refused(operator: str) -> None:
    with pytest.raises(CompileError, match="LTL202"):
        parse(f"{operator} " * MANY + "a")
    with pytest.raises(CompileError, match="LTL202"):
        parse(f"{operator}(" * MANY + "a" + ")" * MANY)


@pytest.mark.parametrize("operator", BINARY)
@pytest.mark.parametrize("right", [True, False])
def test_what_is_just_not_refused_works_in_every_pass(operator: str, right: bool) -> None:
    run_all(nested(operator, MAX_DEPTH, right))
    if operator not in ("&", "|"):
        with pytest.raises(CompileError, match="LTL202"):
            parse(nested(operator, MAX_DEPTH + 1, right))


@pytest.mark.parametrize("operators", ["!", "X", "F", "G", "FG", "GX", "!X", "XG!F"])
def test_a_tower_of_two_hundred_works_in_every_pass(operators: str) -> None:
    run_all(" ".join((operators * MAX_DEPTH)[:MAX_DEPTH]) + " a")


def test_two_thousand_goals_end_in_a_clear_error() -> None:
    parsed = parse(" & ".join(f"G F p{i}" for i in range(2_000)))
    tried(parsed)
    assert list(irrelevant_propositions(parsed.formula, parsed.propositions)) == []


@pytest.mark.parametrize(
    "text", [f"{'F ' * MANY}a", nested("U", MANY, True), "X[9999] a", "X[1000000] a"]
)
def test_the_commands_refuse_it_too(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = runner(capsys)
    for verb in ("check", "translate"):
        status, out, err = run(verb, text)
        assert (status, out) == (1, "")
        assert err.startswith("error[LTL202]: the formula is too large")
    task = spec(tmp_path, ('"G F r & G !y & G !b"', f'"{text}"'), ("r: dist", "a: dist"))
    for verb in ("lint", "explain", "compile"):
        status, out, err = run(verb, task)
        assert status == 1
        assert "error[LTL202]" in out + err


def test_the_commands_take_ten_thousand_brackets(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = runner(capsys)
    text = "(" * 10_000 + "G F r & G !y & G !b" + ")" * 10_000
    assert run("check", text)[0] == 0
    assert run("translate", text)[0] == 0
    task = spec(tmp_path, ('"G F r & G !y & G !b"', f'"{text}"'))
    assert run("lint", task) == (0, "", "no findings\n")
    status, out, _ = run("explain", task)
    assert status == 0
    assert "(G F r) & (G !y) & (G !b)" in out
