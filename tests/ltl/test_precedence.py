import pytest

from tiloilc.ltl import parse


@pytest.mark.parametrize(
    ("text", "shown", "reading", "other"),
    [
        ("G a -> F b", "G a -> F b", "(G a) -> F b", "G (a -> F b)"),
        ("c & (G !a -> b)", "G !a -> b", "(G !a) -> b", "G (!a -> b)"),
        ("F a U b", "F a U b", "(F a) U b", "F (a U b)"),
        ("a & b U c", "a & b U c", "a & (b U c)", "(a & b) U c"),
        ("a U b | c", "a U b | c", "(a U b) | c", "a U (b | c)"),
        ("a U b R c", "a U b R c", "a U (b R c)", "(a U b) R c"),
        ("a -> b <-> c", "a -> b <-> c", "a -> (b <-> c)", "(a -> b) <-> c"),
        ("a <-> b\n -> c", "a <-> b -> c", "a <-> (b -> c)", "(a <-> b) -> c"),
    ],
)
def test_a_surprising_reading_is_shown_with_both_ways_to_bracket_it(
    text: str, shown: str, reading: str, other: str
) -> None:
    (warning,) = parse(text).warnings
    assert warning.code == "LTL214"
    assert warning.message == f"`{shown}` is read as `{reading}`"
    assert warning.help == f"say it with brackets: `{reading}` or `{other}`"
    assert parse(reading).warnings == parse(other).warnings == ()
    assert parse(reading).formula != parse(other).formula


def test_the_caret_is_on_what_is_taken_together() -> None:
    (warning,) = parse("d & (a & bb U c)").warnings
    assert warning.span is not None
    assert (warning.span.column, warning.span.end_column) == (10, 16)


@pytest.mark.parametrize(
    "text",
    [
        "G F (a & X F (b & X F c)) & G !z",
        "F a & G !z",
        "F G y & G !b",
        "(F (y & X F g) | F (r & X F g)) & G !b",
        "(!tray | F(grasp & XF intray)) & (tray | F(grasp & XF ingoal))",
        "!a U b",
        "!a U b & G !c",
        "GFa -> GFb",
        "G (a -> F b)",
        "a & b | c",
        "a -> b -> c",
        "a U b U c",
        "a | (b U c)",
        "(G a) -> F b",
    ],
)
def test_everyday_formulas_are_left_alone(text: str) -> None:
    assert parse(text).warnings == ()
