"""Letters and words as text: what is printed is read back, and much else besides."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.strategies import lassos
from tiloilc.diag import CompileError, SourceText
from tiloilc.ltl import Lasso
from tiloilc.ltl.words import Word, letter_text, parse_word, word_text

NAMES = ("a", "b", "c d", "e,f", 'g"h', "X")


@given(lassos(NAMES))
def test_a_word_that_is_printed_is_read_back(lasso: Lasso) -> None:
    assert parse_word(word_text(lasso, NAMES), NAMES).lasso == lasso


def test_words_are_written_as_sets() -> None:
    assert word_text(Lasso((1, 0), (3,)), ("a", "b")) == "{a} {} then for ever {a, b}"
    assert word_text(Lasso((), (2,)), ("a", "b")) == "for ever {b}"
    assert letter_text(5, NAMES) == '{a, "c d"}'
    assert letter_text(8 + 16, NAMES) == '{"e,f", "g\\"h"}'


@pytest.mark.parametrize(
    ("text", "letters", "loop"),
    [
        ("", (), ()),
        ("{}", (0,), ()),
        ("a", (1,), ()),
        ("a b", (3,), ()),
        ("a,b", (3,), ()),
        ("a & !b", (1,), ()),
        ("!!a && b", (3,), ()),
        ("true", (0,), ()),
        ("a; b", (1, 2), ()),
        ("a;;b;", (1, 0, 2), ()),
        ("{a}{b}", (1, 2), ()),
        ("{a}; {b}; a b", (1, 2, 3), ()),
        ("{a} {} then for ever {b}", (1, 0), (2,)),
        ("a & b; cycle{!a; b}", (3,), (0, 2)),
        ("cycle{{a} {b}}", (), (1, 2)),
        ("for  ever a", (), (1,)),
        ('"c d" a', (5,), ()),
    ],
)
def test_words_are_read(text: str, letters: tuple[int, ...], loop: tuple[int, ...]) -> None:
    assert parse_word(text, NAMES) == Word(letters, loop)


@pytest.mark.parametrize(
    ("text", "column", "told"),
    [
        ("{a", 1, "`{` is never closed"),
        ("a}", 2, "`}` cannot stand here"),
        ("{a} b", 5, "`b` cannot stand here"),
        ("a | b", 3, "`|` is no proposition"),
        ("a & !a", 6, "`a` cannot hold and not hold"),
        ("!", 1, "a proposition is missing"),
        ('"c d', 1, "a quote is never closed"),
        ("cycle{}", 1, "nothing is repeated"),
        ("cycle{a", 1, "`cycle{` is never closed"),
        ("cycle{a} b", 10, "after what is repeated"),
        ("a then for ever", 3, "nothing is repeated"),
    ],
)
def test_what_cannot_be_read_is_said_with_its_place(text: str, column: int, told: str) -> None:
    with pytest.raises(CompileError, match="LTL206") as caught:
        parse_word(SourceText.plain(text, "word"), NAMES)
    (found,) = caught.value.diagnostics
    assert told in found.message
    assert found.span is not None
    assert found.span.column == column


def test_an_unknown_proposition_is_that_of_formulas() -> None:
    with pytest.raises(CompileError, match="LTL203") as caught:
        parse_word("{a, bb}", ("a", "b"))
    assert "did you mean `b`?" in caught.value.diagnostics[0].help


def test_a_proposition_may_be_called_true() -> None:
    assert parse_word("true", ("true", "a")) == Word((1,))


@given(st.text(alphabet='ab {}();,!&|"\\cycle tru', max_size=24))
def test_any_text_is_a_word_or_a_diagnostic(text: str) -> None:
    try:
        word = parse_word(text, ("a", "b"))
    except CompileError:
        return
    assert all(0 <= letter < 4 for letter in word.letters + word.loop)


def test_long_words_are_read_quickly_enough_to_paste() -> None:
    generator = random.Random("long")
    letters = tuple(generator.randrange(4) for _ in range(20_000))
    text = " ".join(letter_text(letter, ("a", "b")) for letter in letters)
    assert parse_word(text, ("a", "b")) == Word(letters)
