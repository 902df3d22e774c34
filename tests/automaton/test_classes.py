"""The classes of the safety–progress hierarchy, and shortest words."""

import random
from itertools import product

import pytest

from tests.strategies import random_formula
from tiloilc.automaton import accepts, satisfying_word, translate
from tiloilc.automaton.language.classes import formula_class, hierarchy_class
from tiloilc.automaton.language.compare import irrelevant_propositions
from tiloilc.automaton.language.questions import equivalent, small_budget
from tiloilc.automaton.language.shortest import shortest_word
from tiloilc.diag import CompileError
from tiloilc.ltl import Lasso, holds, parse, to_text
from tiloilc.ltl.ast import Not
from tiloilc.ltl.hierarchy import Hierarchy, syntactic_class

NAMES = ("a", "b")

KNOWN = {
    Hierarchy.BOUNDED: ["true", "a", "X (a | X b)", "G a & F !a", "F a | G !a"],
    Hierarchy.SAFETY: [
        "G a",
        "a W b",
        "G a | G b",
        "G (a -> X b)",
        "a U G a",
        "a R b",
        "G (a & G b)",
    ],
    Hierarchy.GUARANTEE: ["F a", "a U b", "F a & F b", "F (a & X F b)", "a M b", "F a | G F a"],
    Hierarchy.OBLIGATION: ["G a | F b", "F a & G b", "F a -> F b", "(G a | F b) & (G b | F a)"],
    Hierarchy.RECURRENCE: [
        "G F a",
        "G (a -> F b)",
        "G F a & G F b",
        "G F (a & X F b) & G !b | G F a",
        "G (F a | G b)",
        "F G a | G F a",
        "a W G F b",
    ],
    Hierarchy.PERSISTENCE: ["F G a", "F (a & X G b)", "a U G b", "F G a | F G b", "G (a | F G b)"],
    Hierarchy.REACTIVITY: ["G F a | F G b", "G F a -> G F b", "G F a & F G b", "F G (a U b)"],
}
"""By hand, most from Manna and Pnueli (1990) and Spot's documentation of its classes."""

DUAL = {
    **{kind: kind for kind in Hierarchy},
    Hierarchy.SAFETY: Hierarchy.GUARANTEE,
    Hierarchy.GUARANTEE: Hierarchy.SAFETY,
    Hierarchy.RECURRENCE: Hierarchy.PERSISTENCE,
    Hierarchy.PERSISTENCE: Hierarchy.RECURRENCE,
}
ABOVE = {
    Hierarchy.BOUNDED: set(Hierarchy),
    Hierarchy.SAFETY: set(Hierarchy) - {Hierarchy.BOUNDED, Hierarchy.GUARANTEE},
    Hierarchy.GUARANTEE: set(Hierarchy) - {Hierarchy.BOUNDED, Hierarchy.SAFETY},
    Hierarchy.OBLIGATION: {
        Hierarchy.OBLIGATION,
        Hierarchy.RECURRENCE,
        Hierarchy.PERSISTENCE,
        Hierarchy.REACTIVITY,
    },
    Hierarchy.RECURRENCE: {Hierarchy.RECURRENCE, Hierarchy.REACTIVITY},
    Hierarchy.PERSISTENCE: {Hierarchy.PERSISTENCE, Hierarchy.REACTIVITY},
    Hierarchy.REACTIVITY: {Hierarchy.REACTIVITY},
}


@pytest.mark.parametrize(
    ("text", "wanted"), [(text, kind) for kind, texts in KNOWN.items() for text in texts]
)
def test_the_class_of_a_known_formula_is_decided(text: str, wanted: Hierarchy) -> None:
    formula = parse(text).formula
    for acceptance in ("state", "edge"):
        ldba = translate(formula, NAMES, acceptance=acceptance)
        assert hierarchy_class(ldba) is wanted
    assert syntactic_class(formula) in ABOVE[wanted]


def test_the_negation_is_in_the_dual_class_and_the_syntax_shows_no_less() -> None:
    generator = random.Random(6)
    seen = set()
    for _ in range(1_000):
        formula = random_formula(generator, NAMES, 10)
        found = hierarchy_class(translate(formula, NAMES))
        seen.add(found)
        assert hierarchy_class(translate(Not(formula), NAMES)) is DUAL[found], to_text(formula)
        assert syntactic_class(formula) in ABOVE[found], to_text(formula)
    assert seen == set(Hierarchy)


def test_the_syntactic_class_is_that_of_the_dual_for_the_negation() -> None:
    generator = random.Random(7)
    for _ in range(1_000):
        formula = random_formula(generator, NAMES, 12)
        assert syntactic_class(Not(formula)) is DUAL[syntactic_class(formula)], to_text(formula)


def test_where_the_automaton_is_too_large_the_syntax_answers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    formula = parse("F G a & G (b | G F a)").formula
    ldba = translate(formula, NAMES)
    with pytest.raises(CompileError, match="AUT305"):
        hierarchy_class(ldba, max_states=1)
    monkeypatch.setattr(
        "tiloilc.automaton.language.classes.hierarchy_class",
        lambda ldba: hierarchy_class(ldba, max_states=1),
    )
    assert formula_class(formula, ldba) is syntactic_class(formula)


def test_a_shortest_word_is_a_word_and_none_is_shorter() -> None:
    generator = random.Random(8)
    for _ in range(300):
        formula = random_formula(generator, NAMES, 9)
        known = satisfying_word(formula, NAMES)
        if known is None:
            continue
        word = shortest_word(formula, NAMES, known)
        assert holds(formula, word, NAMES), to_text(formula)
        length = len(word.letters)
        for shorter in range(1, min(length, 3)):
            for letters in product(range(4), repeat=shorter):
                for back in range(shorter):
                    other = Lasso(letters[:back], letters[back:])
                    assert not holds(formula, other, NAMES), (to_text(formula), other)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("G F a & G F b", Lasso((), (3,))),
        ("F (a & X F (b & !a))", Lasso((1,), (2,))),
        ("a & X !a & X X G b", Lasso((1,), (2,))),
        ("G (a <-> X !a)", Lasso((), (1, 0))),
        ("F a & G F !a", Lasso((1,), (0,))),
    ],
)
def test_shortest_words_have_few_letters_and_few_propositions(text: str, wanted: Lasso) -> None:
    formula = parse(text).formula
    known = satisfying_word(formula, NAMES)
    assert known is not None
    assert shortest_word(formula, NAMES, known) == wanted
    assert accepts(translate(formula, NAMES), wanted)


def test_a_word_too_long_to_search_for_is_the_known_one() -> None:
    formula = parse("X[9] a & G (a -> X G !a) & !a").formula
    known = satisfying_word(formula, NAMES)
    assert known is not None
    assert shortest_word(formula, NAMES, known) == known


def test_equivalence_and_idle_propositions() -> None:
    chain, both = parse("G F (a & X F b)").formula, parse("G F a & G F b").formula
    assert equivalent(chain, both, NAMES, small_budget())
    assert not equivalent(chain, parse("G F a").formula, NAMES, small_budget())
    assert list(irrelevant_propositions(parse("F a | F (a & b)").formula, NAMES)) == ["b"]
