import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strategies import formulas, lassos
from tiloilc.automaton.language.compare import irrelevant_propositions
from tiloilc.driver.vacuity import irrelevant_parts
from tiloilc.ltl import Lasso, Syntax, holds, parse, to_text
from tiloilc.ltl.ast import Formula

NAMES = ("a", "b", "c")


def parts(text: str) -> list[str]:
    """The text of the parts that do not matter."""
    return [text[p.start : p.end] for p, _ in irrelevant_parts(parse(text, NAMES).syntax, NAMES)]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("G F (a & X F b) & G !c", []),
        ("F a & F (a | b)", ["F (a | b)"]),
        ("F (a | b) & F a", ["F (a | b)"]),
        ("G a & (b U a)", ["(b U a)"]),
        ("F (a & X F b) & F (b | c)", ["F (b | c)"]),
        ("F G a & G !b", []),
        ("F a & F a", ["F a"]),
        ("G (a -> b) & (a -> b) & F a", ["(a -> b)"]),
        ("(a & b) | (a & !b)", ["(a & b)", "!b"]),
        ("F (a U b)", ["a"]),
        ("G F a & (a | c)", []),
        ("!(G a | a)", ["G a"]),
        ("F[0:2] (a & (a | b))", ["(a | b)"]),
    ],
)
def test_the_largest_parts_that_do_not_matter_are_named_where_they_stand(
    text: str, wanted: list[str]
) -> None:
    assert parts(text) == wanted


def test_of_equal_parts_only_the_one_that_does_not_matter_is_named() -> None:
    text = "F b & (a | F b & c)"
    ((part, _),) = irrelevant_parts(parse(text, NAMES).syntax, NAMES)
    assert (part.start, text[part.start : part.end]) == (11, "F b")


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("G F (a & X F b)", []),
        ("a ^ b ^ b", ["b"]),
        ("(F a <-> b) <-> b", ["b"]),
        ("G (a | b) & G (a | !b)", ["b"]),
        ("F a | F (a & b & c)", ["b", "c"]),
    ],
)
def test_propositions_that_never_matter_are_named(text: str, wanted: list[str]) -> None:
    assert list(irrelevant_propositions(parse(text, NAMES).formula, NAMES)) == wanted


def over(node: Syntax, gone: dict[tuple[int, int], Formula]) -> Formula:
    """The formula of `node` with others for the parts that stand in some places of the text."""
    if (node.start, node.end) in gone:
        return gone[node.start, node.end]
    return node.over([over(part, gone) for part in node.parts]) if node.parts else node.formula


@settings(max_examples=100)
@given(formulas(NAMES, 7), st.lists(lassos(NAMES), min_size=4, max_size=4))
def test_words_cannot_tell_a_formula_from_one_without_what_does_not_matter(
    formula: Formula, words: list[Lasso]
) -> None:
    syntax = parse(to_text(formula), NAMES).syntax
    found = irrelevant_parts(syntax, NAMES)
    changed = over(syntax, {(part.start, part.end): value for part, value in found})
    for word in words:
        assert holds(changed, word, NAMES) == holds(formula, word, NAMES), to_text(formula)


@settings(max_examples=60)
@given(formulas(NAMES, 6), lassos(NAMES))
def test_words_do_not_depend_on_propositions_that_never_matter(
    formula: Formula, word: Lasso
) -> None:
    for name in irrelevant_propositions(formula, NAMES):
        bit = 1 << NAMES.index(name)
        flipped = Lasso(tuple(x ^ bit for x in word.stem), tuple(x ^ bit for x in word.loop))
        assert holds(formula, flipped, NAMES) == holds(formula, word, NAMES)
