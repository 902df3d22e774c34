import pytest

from tiloilc.ltl import parse, to_text
from tiloilc.ltl.ast import Proposition


@pytest.mark.parametrize(
    "text",
    [
        "G F (a & X F (b & X F c)) & G !z",
        "(a -> b) -> c",
        "a -> b -> c",
        "a -> (b <-> c)",
        "(a | b) & c | d",
        "a ^ b ^ c",
        "a ^ (b ^ c)",
        "(a U b) U c",
        "a U b U c",
        "a U (b R c)",
        "!(a U b)",
        "!a U b",
        "a & (b & c)",
        "X (a W b) M c",
        "true U false",
    ],
)
def test_brackets_stand_only_where_they_help(text: str) -> None:
    formula = parse(text).formula
    assert to_text(formula) == text
    assert parse(to_text(formula)).formula == formula


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("a & b U c", "a & (b U c)"),
        ("!a U b -> G F c", "((!a) U b) -> (G F c)"),
        ("GF(a & XF b) & G !z", "(G F (a & (X F b))) & (G !z)"),
        ("a | b | c", "a | b | c"),
    ],
)
def test_all_brackets_leave_nothing_to_precedence(text: str, wanted: str) -> None:
    formula = parse(text).formula
    assert to_text(formula, brackets=True) == wanted
    assert parse(wanted).formula == formula


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("goal", "goal"),
        ("_a.b", "_a.b"),
        ("F1", "F1"),
        ("a b", '"a b"'),
        ("GoalReached", '"GoalReached"'),
        ("F", '"F"'),
        ("true", '"true"'),
        ("until", '"until"'),
        ("AND", '"AND"'),
        ("1a", '"1a"'),
        ("größe", '"größe"'),
        ('say "x\\y"', '"say \\"x\\\\y\\""'),
    ],
)
def test_a_name_is_quoted_just_if_it_could_be_misread(name: str, wanted: str) -> None:
    assert to_text(Proposition(name)) == wanted
    assert parse(wanted).formula == Proposition(name)
