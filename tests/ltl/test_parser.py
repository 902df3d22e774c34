import pytest

from tiloilc.diag import CompileError, SourceText, Span
from tiloilc.ltl import parse, to_text
from tiloilc.ltl.ast import FALSE, TRUE
from tiloilc.ltl.syntax import MAX_DEPTH


def bracketed(text: str, declared: list[str] | None = None) -> str:
    return to_text(parse(text, declared).formula, brackets=True)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("!a U b", "(!a) U b"),
        ("F a U b", "(F a) U b"),
        ("a U b U c", "a U (b U c)"),
        ("a U b R c", "a U (b R c)"),
        ("a W b M c", "a W (b M c)"),
        ("a U b & c", "(a U b) & c"),
        ("a & b ^ c", "(a & b) ^ c"),
        ("a ^ b ^ c", "(a ^ b) ^ c"),
        ("a | b ^ c", "a | (b ^ c)"),
        ("a | b & c | d", "a | (b & c) | d"),
        ("a | b -> c", "(a | b) -> c"),
        ("a -> b -> c", "a -> (b -> c)"),
        ("a -> b <-> c", "a -> (b <-> c)"),
        ("a <-> b -> c", "a <-> (b -> c)"),
        ("G a -> F b", "(G a) -> (F b)"),
        ("X !a & b", "(X !a) & b"),
    ],
)
def test_precedence_and_associativity_are_those_of_spot(text: str, wanted: str) -> None:
    assert bracketed(text) == wanted


@pytest.mark.parametrize(
    ("spellings", "wanted"),
    [
        ("! ~ ¬ not NOT", "!a"),
        ("X next ○ ()", "X a"),
        ("F <> ◇ ♢ eventually finally", "F a"),
        ("G [] □ always globally Globally", "G a"),
    ],
)
def test_unary_operators_have_many_spellings(spellings: str, wanted: str) -> None:
    for spelling in spellings.split():
        assert to_text(parse(f"{spelling} a").formula) == wanted


@pytest.mark.parametrize(
    ("spellings", "sign"),
    [
        ("& && /\\ ∧ and", "&"),
        ("| || \\/ ∨ or", "|"),
        ("^ xor ⊕", "^"),
        ("-> => → --> implies", "->"),
        ("<-> <=> ↔ <--> iff", "<->"),
        ("U until", "U"),
        ("R V release releases", "R"),
        ("W weak weak_until", "W"),
        ("M strong_release", "M"),
    ],
)
def test_binary_operators_have_many_spellings(spellings: str, sign: str) -> None:
    for spelling in spellings.split():
        assert to_text(parse(f"a {spelling} b").formula) == f"a {sign} b"


def test_weak_until_may_be_two_words() -> None:
    assert to_text(parse("a weak until b strong release c").formula) == "a W (b M c)"


def test_constants_have_many_spellings() -> None:
    for text in ["true", "True", "TRUE", "tt", "1", "⊤"]:
        assert parse(text).formula == TRUE
    for text in ["false", "False", "FALSE", "ff", "0", "⊥"]:
        assert parse(text).formula == FALSE


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("GFa", "G F a"),
        ("FGa & XXb", "(F G a) & (X X b)"),
        ("Ftrue", "F true"),
        ("F1", "F1"),
        ("FF1", "F F1"),
        ("aUb", "aUb"),
        ("a Ub", "a U b"),
        ("(a)UFb", "a U (F b)"),
        ("p=0Uq=1", "(!p) U q"),
        ("X[]a", "X G a"),
        ("a /* why */ & b", "a & b"),
        ("a\n  & b", "a & b"),
        ('"GFa" & "a b"', '"GFa" & "a b"'),
    ],
)
def test_words_are_cut_as_spot_cuts_them(text: str, wanted: str) -> None:
    assert bracketed(text) == wanted


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("X[3] a", "X X X a"),
        ("F[2:4] a", "X X (a | X (a | X a))"),
        ("GF[1..2]a", "G X (a | X a)"),
        ("<>[0,1] (a & b)", "(a & b) | X (a & b)"),
        ("G[0:1] a", "a & X a"),
        ("G[2:] a U b", "X X G a U b"),
        ("F [1..$] a", "X F a"),
        ("F[0:0] a", "a"),
    ],
)
def test_bounded_operators_are_written_out(text: str, wanted: str) -> None:
    assert parse(text).formula == parse(wanted).formula


@pytest.mark.parametrize(
    ("text", "declared", "wanted"),
    [
        ("GoalReached", ["GoalReached"], '"GoalReached"'),
        ("F GoalReached & GGoalReached", ["GoalReached"], '(F "GoalReached") & (G "GoalReached")'),
        ("GFa", ["a"], "G F a"),
        ("until U next", ["until", "next"], '"until" U "next"'),
        ("a U U", ["a", "U"], 'a U "U"'),
        ("G a & G", ["a", "G"], '(G a) & "G"'),
        ("F (a & F)", ["a", "F"], 'F (a & "F")'),
        ("tt & a", ["tt", "a"], '"tt" & a'),
    ],
)
def test_declared_propositions_win_over_operators(
    text: str, declared: list[str], wanted: str
) -> None:
    assert bracketed(text, declared) == wanted


@pytest.mark.parametrize(
    ("text", "declared", "message"),
    [
        ("GFa", ["Fa", "a"], "`Fa` is read as the proposition `Fa`, not as `F a`"),
        ("GFa", ["GFa", "a"], "`GFa` is read as the proposition `GFa`, not as `G F a`"),
        (
            "tt & a",
            ["tt", "a"],
            "`tt` is read as the declared proposition, not as the operator or constant",
        ),
    ],
)
def test_a_word_with_two_readings_is_a_warning_that_says_which(
    text: str, declared: list[str], message: str
) -> None:
    (warning,) = parse(text, declared).warnings
    assert (warning.code, warning.message) == ("LTL205", message)


@pytest.mark.parametrize(
    ("text", "declared"),
    [("GFa", ["a", "GFb"]), ("G a & G", ["a", "G"]), ('"Fa"', ["Fa", "a"]), ("F1", ["F1"])],
)
def test_a_word_with_one_reading_is_no_warning(text: str, declared: list[str]) -> None:
    assert parse(text, declared).warnings == ()


def test_parsed_tells_where_each_proposition_stands() -> None:
    parsed = parse("GFbb &\n a | bb", ["a", "bb", "c"])
    assert parsed.occurrences == (
        ("bb", Span("<formula>", 1, 3, 1, 5)),
        ("a", Span("<formula>", 2, 2, 2, 3)),
        ("bb", Span("<formula>", 2, 6, 2, 8)),
    )
    assert parsed.propositions == ("a", "bb", "c")
    assert parse("b & a & b").propositions == ("b", "a")


def test_places_are_those_of_the_file() -> None:
    text = SourceText("F cc", "t.yaml", ((3, 11), (3, 12), (4, 5), (4, 6), (4, 7)))
    with pytest.raises(CompileError) as caught:
        parse(text, ["c"])
    assert caught.value.diagnostics[0].span == Span("t.yaml", 4, 5, 4, 7)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 10_000 + "a" + ")" * 10_000,
        " & ".join(["a", "b"] * 2_501),
        "X" * MAX_DEPTH + "a",
        "/* x " * 10_000 + "*/ a",
    ],
)
def test_long_and_deep_text_works_within_the_limits(text: str) -> None:
    assert parse(text).propositions[0] == "a"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("!" * 5_000 + "a", "LTL202"),
        ("X" * (MAX_DEPTH + 1) + "a", "LTL202"),
        (" -> ".join(["a"] * 5_001), "LTL202"),
        ("G(" * 5_000 + "a" + ")" * 5_000, "LTL202"),
        ("a" * 100_001, "LTL202"),
        ("F[0:150] a", "LTL202"),
        ("X[100] F[999999:] a", "LTL202"),
        ("(" * 10_000, "LTL201"),
        ("a" + ")" * 10_000, "LTL201"),
        ("G" * 50_000, "LTL201"),
        ('"' * 10_001, "LTL201"),
        ("/* x " * 10_000, "LTL201"),
    ],
)
def test_beyond_the_limits_comes_a_coded_error(text: str, code: str) -> None:
    with pytest.raises(CompileError) as caught:
        parse(text)
    assert {d.code for d in caught.value.diagnostics} == {code}
