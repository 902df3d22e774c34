"""What the reader of a broken formula sees: text, caret, label and help."""

import random

import pytest

from tiloilc.diag import CompileError, Diagnostic, SourceText
from tiloilc.ltl import parse

DECLARED = ["a", "b", "c"]


def findings(text: str, declared: list[str] | None) -> tuple[Diagnostic, ...]:
    with pytest.raises(CompileError) as caught:
        parse(text, declared)
    return caught.value.diagnostics


def caret(text: str, finding: Diagnostic) -> str:
    """The characters that the caret marks."""
    span = finding.span
    assert span is not None
    assert span.line == span.end_line == 1
    return text[span.column - 1 : span.end_column - 1]


@pytest.mark.parametrize(
    ("text", "problem", "marked", "label"),
    [
        ("", "expected a formula, found nothing", "", "empty"),
        ("a & ", "expected a formula after `&`", "&", "nothing follows"),
        ("a & | b", "expected a formula after `&`, found `|`", "|", None),
        ("& a", "expected a formula, found `&`", "&", None),
        ("! -> a", "expected a formula after `!`, found `->`", "->", None),
        ("(a | b", "expected `)` before the end of the formula", "(", "never closed"),
        ("((a) | (b", "expected `)` before the end of the formula", "(", "never closed"),
        (
            "a)",
            "expected an operator or the end of the formula, found `)`",
            ")",
            "closes no bracket",
        ),
        ("( ) & a", "expected a formula between `(` and `)`", "( )", "empty brackets"),
        (
            "F a b",
            "expected an operator after `a`, found `b`",
            "b",
            "expected `&`, `|`, `->` or `U` before this",
        ),
        ("(a) !b", "expected an operator after `)`, found `!`", "!", None),
        (
            "a @ b",
            "expected an operator or a proposition, found `@`",
            "@",
            "not part of the formula language",
        ),
        ('F "a b', 'expected a closing `"` before the end of the formula', '"', "never closed"),
        ("a /* b", "expected a closing `*/` before the end of the formula", "/*", "never closed"),
        (
            "2x & a",
            "expected a proposition, found `2x`",
            "2x",
            "a name does not begin with a digit",
        ),
        ("a \x07", "expected an operator or a proposition, found `\\x07`", "\x07", None),
    ],
)
def test_a_syntax_error_names_what_was_expected_and_marks_it(
    text: str, problem: str, marked: str, label: str | None
) -> None:
    (finding,) = findings(text, None)
    assert finding.code == "LTL201"
    assert finding.message == f"cannot read the formula: {problem}"
    assert caret(text, finding) == marked
    assert label is None or finding.label == label


@pytest.mark.parametrize(
    ("text", "help"),
    [
        ("a == b", "equality of truth values is `<->`"),
        ("F[2] a", "F takes two bounds: `F[0:2]` or `F[2:]`"),
        ("a - b", "implication is `->`, negation is `!`"),
        ("dist < 3", "comparisons belong into the definition of a proposition"),
        ("a and or b", '`or` is an operator; a proposition of this name is written `"or"`'),
    ],
)
def test_a_syntax_error_knows_what_was_probably_meant(text: str, help: str) -> None:
    assert findings(text, None)[0].help == help


def test_an_unknown_proposition_is_marked_and_corrected() -> None:
    text = "F (a & X F (b & X F cc))"
    (finding,) = findings(text, DECLARED)
    assert (finding.code, finding.message) == ("LTL203", "unknown proposition `cc`")
    assert caret(text, finding) == "cc"
    assert finding.label == "not declared"
    assert finding.help == "did you mean `c`? declared: a, b, c"


@pytest.mark.parametrize(
    ("text", "declared", "name", "help"),
    [
        ("GFzz", DECLARED, "zz", "declared: a, b, c"),
        ("GFcc", DECLARED, "cc", "did you mean `c`? declared: a, b, c"),
        (
            "GoalReach",
            ["GoalReached"],
            "GoalReach",
            "did you mean `GoalReached`? declared: GoalReached",
        ),
        (
            "GoalReached",
            ["goalreached"],
            "GoalReached",
            "did you mean `goalreached`? declared: goalreached",
        ),
        ("aUb", DECLARED, "aUb", "did you mean `a U b`? declared: a, b, c"),
        ('"a b"', DECLARED, "a b", "declared: a, b, c"),
        ("a", [], "a", "declared: none"),
    ],
)
def test_the_unknown_part_of_a_word_is_named(
    text: str, declared: list[str], name: str, help: str
) -> None:
    (finding,) = findings(text, declared)
    assert (finding.message, finding.help) == (f"unknown proposition `{name}`", help)
    assert caret(text, finding).strip('"') == name


def test_all_errors_come_at_once_in_the_order_of_their_places() -> None:
    text = "x & y | (z & )"
    found = findings(text, DECLARED)
    assert [d.code for d in found] == ["LTL203", "LTL203", "LTL203", "LTL201"]
    assert [caret(text, d) for d in found] == ["x", "y", "z", ")"]


def test_a_word_in_the_place_of_an_operator_is_not_called_unknown_as_well() -> None:
    assert [d.code for d in findings("a und b", DECLARED)] == ["LTL201"]


def test_too_deep_a_formula_is_marked_where_the_limit_is_crossed() -> None:
    (finding,) = findings("X" * 205 + "a", None)
    assert finding.message == "the formula is too large: operators are nested more than 200 deep"
    assert finding.span is not None
    assert finding.span.column == 5


@pytest.mark.parametrize("digits", [7, 50, 5_000])
@pytest.mark.parametrize("bounded", ["X[{}]", "F[0:{}]", "G[{}:]", "F[{}..$]", "G[{},{}]"])
def test_bounds_of_any_length_are_too_large_not_no_bounds(bounded: str, digits: int) -> None:
    text = f"{bounded.replace('{}', '9' * digits)} a"
    (finding,) = findings(text, None)
    assert finding.code == "LTL202"
    assert finding.message == "the formula is too large: operators are nested more than 200 deep"


def test_a_bound_may_have_zeros_before_it() -> None:
    assert parse("X[00000000003] a").formula == parse("X[3] a").formula


SNIPPETS = [
    *"abc()!&|^~FGXUWRMV01\"'`@#$%=<>-+*/\\[]{};:,.? \n\t_éω∧◇⊥\x00",
    *["->", "<->", "<>", "[]", "/*", "*/", "true", "until", "weak", "not", "=1", "GFa", "3x", "😀"],
]


def test_no_text_ends_in_anything_but_a_formula_or_findings() -> None:
    generator = random.Random(20)
    found: list[Diagnostic] = []
    for _ in range(20_000):
        text = "".join(generator.choices(SNIPPETS, k=generator.randint(0, 12)))
        try:
            parse(text, DECLARED if generator.random() < 0.5 else None)
        except CompileError as error:
            found.extend(error.diagnostics)
    assert {finding.code for finding in found} == {"LTL201", "LTL203"}
    assert all(finding.span is not None for finding in found)


def test_no_message_shows_a_name_of_the_grammar() -> None:
    generator = random.Random(21)
    shown: list[str] = []
    for _ in range(2_000):
        text = "".join(generator.choices(["a", "(", ")", "!", "&", "U", " ", "@"], k=6))
        try:
            parse(SourceText.plain(text))
        except CompileError as error:
            shown += [d.message + d.label + d.help for d in error.diagnostics]
    everything = " ".join(shown)
    for kind in ("NAME", "OPEN", "UNTIL", "$END", "Token"):
        assert kind not in everything
