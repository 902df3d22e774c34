"""The oracle of every pass: formula and automaton agree on random ultimately periodic words."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given

from tests.strategies import formulas, lassos, random_formula, random_lasso
from tiloilc.automaton import Ldba, accepts, to_hoa, translate
from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.draft import Draft
from tiloilc.automaton.finish import draft_of, edge_based, state_based, with_edge_acceptance
from tiloilc.automaton.implication import Implications
from tiloilc.automaton.limits import Budget
from tiloilc.automaton.reduce import PASSES
from tiloilc.automaton.symmetric import Symmetric
from tiloilc.automaton.terms import Terms
from tiloilc.automaton.translate import build
from tiloilc.automaton.unfolding import Unfolding
from tiloilc.ltl import Lasso, holds, parse, to_text
from tiloilc.ltl.ast import Formula

ABC = ("a", "b", "c")
MAX_SIZE = 12

WORDS_PER_FORMULA = 8
EXAMPLES = 20_000
"""Pairs of a formula and a word, each looked at after every pass."""


@given(formulas(ABC, MAX_SIZE), lassos(ABC))
def test_an_automaton_accepts_just_the_words_of_its_formula(formula: Formula, lasso: Lasso) -> None:
    assert accepts(translate(formula, ABC), lasso) == holds(formula, lasso, ABC)


@given(formulas(ABC, MAX_SIZE), lassos(ABC))
def test_so_it_does_with_marked_edges(formula: Formula, lasso: Lasso) -> None:
    ldba = translate(formula, ABC, acceptance="edge")
    assert accepts(ldba, lasso) == holds(formula, lasso, ABC)


@given(formulas(ABC, MAX_SIZE), lassos(ABC))
def test_the_laws_of_the_term_constructors_hold(formula: Formula, lasso: Lasso) -> None:
    terms = Terms(ABC, Budget())
    lawful = terms.formula(terms.of(formula))
    assert holds(lawful, lasso, ABC) == holds(formula, lasso, ABC), to_text(lawful)


@given(formulas(ABC, 8), formulas(ABC, 8), lassos(ABC))
def test_implications_found_by_syntax_hold(left: Formula, right: Formula, lasso: Lasso) -> None:
    terms = Terms(ABC, Budget())
    if Implications(terms).implies(terms.of(left), terms.of(right)):
        assert holds(right, lasso, ABC) or not holds(left, lasso, ABC)


def test_implications_hold_on_many_close_formulas() -> None:
    """Random pairs seldom imply each other; pairs of sub-formulas of one table often do."""
    generator = random.Random("implications")
    found = 0
    for _ in range(150):
        terms = Terms(("a", "b"), Budget())
        known = Implications(terms)
        parts = [terms.of(random_formula(generator, ("a", "b"), 4)) for _ in range(14)]
        words = [random_lasso(generator, ("a", "b"), 3, 3) for _ in range(12)]
        truth = {t: [holds(terms.formula(t), w, ("a", "b")) for w in words] for t in set(parts)}
        for left in truth:
            for right in truth:
                if left != right and known.implies(left, right):
                    found += 1
                    pairs = zip(truth[left], truth[right], strict=True)
                    assert all(b or not a for a, b in pairs)
    assert found > 1000


def stations(formula: Formula, propositions: Sequence[str]) -> Iterator[tuple[str, Ldba]]:
    """The automaton of `formula` after construction, after every pass, and finished."""
    budget = Budget()
    diagrams = Diagrams(budget)
    draft = build(Symmetric(Unfolding(Terms(propositions, budget), diagrams)), formula)
    finish = partial(edge_based, propositions=tuple(propositions), diagrams=diagrams)
    yield "construction", finish(_nameless(draft))
    for step in PASSES:
        draft = step(draft, diagrams)
        yield step.__name__, finish(_nameless(draft))
    done = state_based(_nameless(draft), tuple(propositions), diagrams)
    yield "accepting states", done
    yield "marked edges again", with_edge_acceptance(done)
    yield "draft again", edge_based(draft_of(done, diagrams), tuple(propositions), diagrams)


def _nameless(draft: Draft) -> Draft:
    return replace(draft, names=(str,) * len(draft.rows))


@pytest.mark.slow
def test_no_pass_changes_the_language() -> None:
    generator = random.Random("twenty thousand")
    for _ in range(EXAMPLES // WORDS_PER_FORMULA):
        formula = random_formula(generator, ABC, MAX_SIZE)
        words = [random_lasso(generator, ABC) for _ in range(WORDS_PER_FORMULA)]
        expected = [holds(formula, word, ABC) for word in words]
        last = None
        for name, ldba in stations(formula, ABC):
            if ldba == last:
                continue
            last = ldba
            assert [accepts(ldba, w) for w in words] == expected, f"{to_text(formula)}: {name}"


def test_no_pass_changes_the_language_of_formulas_that_need_jumps() -> None:
    """Boolean combinations of FG and GF: the general construction, which random formulas miss."""
    generator = random.Random("jumps")
    jumping = 0
    for _ in range(150):
        parts = [
            f"({generator.choice(['F G', 'G F', 'F G', 'G', 'F'])}"
            f" ({to_text(random_formula(generator, ABC, 3))}))"
            for _ in range(3)
        ]
        inner, outer = generator.choice("&|"), generator.choice("&|")
        text = f"({parts[0]} {inner} {parts[1]}) {outer} {parts[2]}"
        formula = parse(text, ABC).formula
        jumping += bool(translate(formula, ABC).jumps)
        words = [random_lasso(generator, ABC) for _ in range(WORDS_PER_FORMULA)]
        expected = [holds(formula, word, ABC) for word in words]
        for name, ldba in stations(formula, ABC):
            assert [accepts(ldba, w) for w in words] == expected, f"{text}: {name}"
    assert jumping > 40


def test_the_written_text_does_not_depend_on_earlier_translations() -> None:
    generator = random.Random("again")
    some = [random_formula(generator, ABC, MAX_SIZE) for _ in range(40)]
    first = [to_hoa(translate(formula, ABC)) for formula in some]
    again = [to_hoa(translate(formula, ABC)) for formula in reversed(some)]
    assert first == again[::-1]
