import pytest

from tiloilc.ltl import Lasso, after, holds, is_cosafety, is_safety, nnf, parse, to_text, unfold
from tiloilc.ltl.ast import Always, Eventually, Not, Proposition, conjunction, propositions_of
from tiloilc.ltl.fragments import is_eventual, is_suspendable, is_universal

AB = ("a", "b")
NONE, A, B, BOTH = 0, 1, 2, 3


@pytest.mark.parametrize(
    ("text", "stem", "loop", "wanted"),
    [
        ("a", (A,), (NONE,), True),
        ("X a", (A,), (NONE,), False),
        ("X X a", (), (A, NONE), True),
        ("F a", (NONE, NONE), (NONE, A), True),
        ("F a", (A,), (NONE,), True),
        ("X F a", (A,), (NONE,), False),
        ("G a", (A,), (A, NONE), False),
        ("F G a", (NONE,), (A,), True),
        ("G F a", (A, A), (NONE,), False),
        ("a U b", (A, A), (B,), True),
        ("a U b", (), (A,), False),
        ("a W b", (), (A,), True),
        ("a W b", (A, NONE), (B,), False),
        ("a R b", (B, BOTH), (NONE,), True),
        ("a R b", (B, A), (NONE,), False),
        ("a R b", (), (B,), True),
        ("a M b", (), (B,), False),
        ("a M b", (B,), (BOTH,), True),
        ("a -> b", (), (A,), False),
        ("a <-> b", (), (BOTH,), True),
        ("a ^ b", (), (BOTH,), False),
        ("G F (a & X F b)", (), (B, A), True),
    ],
)
def test_semantics_on_words_that_one_can_check_by_hand(
    text: str, stem: tuple[int, ...], loop: tuple[int, ...], wanted: bool
) -> None:
    assert holds(parse(text).formula, Lasso(stem, loop), AB) is wanted


def test_a_suffix_is_the_word_without_its_beginning() -> None:
    word = Lasso((1, 2), (3, 4, 5))
    assert word.suffix(0) == word
    assert word.suffix(1) == Lasso((2,), (3, 4, 5))
    assert word.suffix(3) == Lasso((), (4, 5, 3))
    assert word.suffix(5) == word.suffix(2)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("!(a U b)", "!a R !b"),
        ("!(a W b)", "!a M !b"),
        ("!(F a & G X b)", "G !a | F X !b"),
        ("a -> b", "!a | b"),
        ("!(a -> b)", "a & !b"),
        ("a <-> F b", "a & F b | !a & G !b"),
        ("!(a ^ b)", "a & b | !a & !b"),
        ("(a & (b & c)) & a", "a & b & c"),
    ],
)
def test_normal_form_pushes_negation_inwards(text: str, wanted: str) -> None:
    assert to_text(nnf(parse(text).formula)) == wanted


@pytest.mark.parametrize(
    ("text", "letter", "wanted"),
    [
        ("a", {"a"}, "true"),
        ("!a", {"a"}, "false"),
        ("X a", set(), "a"),
        ("F a", set(), "F a"),
        ("F a", {"a"}, "true"),
        ("G a", {"a"}, "G a"),
        ("a U b", {"a"}, "a U b"),
        ("a U b", set(), "false"),
        ("a R b", {"b"}, "a R b"),
        ("a R b", {"a", "b"}, "true"),
        ("F (a & X F b)", {"a"}, "F b | F (a & X F b)"),
        ("G F a", set(), "F a & G F a"),
    ],
)
def test_progression_says_what_is_left_to_do(text: str, letter: set[str], wanted: str) -> None:
    assert to_text(after(parse(text).formula, letter)) == wanted


def test_unfolding_leaves_time_under_next_only() -> None:
    assert to_text(unfold(parse("a U b").formula)) == "b | a & X (a U b)"
    assert to_text(unfold(parse("G F a").formula)) == "(a | X F a) & X G F a"


def test_fragments_are_seen_from_the_syntax() -> None:
    assert is_safety(parse("G !a & (b W X c)").formula)
    assert is_safety(parse("!F a").formula)
    assert not is_safety(parse("F a").formula)
    assert is_cosafety(parse("F (a & X F b) | !G c").formula)
    assert not is_cosafety(parse("a W b").formula)


def test_eventual_and_universal_formulas() -> None:
    assert is_eventual(parse("a U F b").formula)
    assert not is_eventual(parse("a U b").formula)
    assert is_universal(parse("G a & (b R G c)").formula)
    assert is_suspendable(parse("G F a | F G b").formula)
    assert not is_suspendable(parse("F a").formula)


def test_equal_formulas_are_equal_wherever_they_come_from() -> None:
    a = Proposition("a")
    one, other = Always(Eventually(a)), Always(Eventually(Proposition("a")))
    assert one == other
    assert hash(one) == hash(other)
    assert one != Eventually(Always(a))
    assert conjunction([a, Not(a), a]) == conjunction([a, Not(a)])
    assert propositions_of(parse("b & (a | b)").formula) == ("b", "a")
