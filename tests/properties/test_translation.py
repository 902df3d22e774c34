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
from tiloilc.automaton.construction.implication import Implications
from tiloilc.automaton.construction.symmetric import Symmetric
from tiloilc.automaton.construction.terms import Terms
from tiloilc.automaton.construction.unfolding import Unfolding
from tiloilc.automaton.draft import Draft, reachable
from tiloilc.automaton.finish import draft_of, edge_based, state_based, with_edge_acceptance
from tiloilc.automaton.limits import Budget
from tiloilc.automaton.reduction.reduce import PASSES
from tiloilc.automaton.translate import build
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


def agrees_after_every_pass(formula: Formula, generator: random.Random) -> None:
    """Check the automaton of `formula` on a few words after every pass."""
    words = [random_lasso(generator, ABC) for _ in range(WORDS_PER_FORMULA)]
    expected = [holds(formula, word, ABC) for word in words]
    last = None
    for name, ldba in stations(formula, ABC):
        if ldba != last:
            assert [accepts(ldba, w) for w in words] == expected, f"{to_text(formula)}: {name}"
        last = ldba


@pytest.mark.slow
def test_no_pass_changes_the_language() -> None:
    generator = random.Random("twenty thousand")
    for _ in range(EXAMPLES // WORDS_PER_FORMULA):
        agrees_after_every_pass(random_formula(generator, ABC, MAX_SIZE), generator)


def test_no_pass_changes_the_language_of_a_few_hundred_formulas() -> None:
    generator = random.Random("a few hundred")
    for _ in range(400):
        agrees_after_every_pass(random_formula(generator, ABC, MAX_SIZE), generator)


TEMPLATES = (
    "F ({0} & G {1})",
    "F (({0}) & G (({1}) | X {2}))",
    "F G ({0}) | G F ({1})",
    "(F G ({0}) & G F ({1})) | G ({2})",
    "F (G (a | ({0})) & ({1}))",
    "({0}) U G ({1})",
    "G (({0}) | F G ({1}))",
    "G F (({0}) & G ({1})) | F ({2})",
    "F (({0}) & (({1}) W ({2})))",
    "G (b -> F ({0})) | F G (c & ({1}))",
    "F G (({0}) M a | ({1}) U c)",
    "F (b & G (c | (({0}) M ({1}))))",
    "F (b & G (c | (({0}) U ({1}))))",
    "(G F ({0}) -> G F ({1})) & (G F ({2}) -> G F a)",
    "F (a & X F b) | F b & ({0})",
    "F ({0}) & F (({0}) | ({1})) | F (({0}) & X ({2}))",
)
"""Shapes that need the general construction, or of which one part implies another."""


@pytest.mark.parametrize("template", TEMPLATES)
def test_no_pass_changes_the_language_of_formulas_that_need_jumps(template: str) -> None:
    generator = random.Random(template)
    for _ in range(25):
        parts = [to_text(random_formula(generator, ABC, 5)) for _ in range(3)]
        agrees_after_every_pass(parse(template.format(*parts), ABC).formula, generator)


def test_jumps_lead_from_a_cycle_to_a_cycle() -> None:
    generator = random.Random("cycles")
    jumping = 0
    for _ in range(300):
        parts = [to_text(random_formula(generator, ABC, 4)) for _ in range(3)]
        text = generator.choice(TEMPLATES).format(*parts)
        ldba = translate(parse(text, ABC).formula, ABC, acceptance="edge")
        targets = [[edge.target for edge in edges] for edges in ldba.outgoing]
        jumping += bool(ldba.jumps)
        for state in {state for jump in ldba.jumps for state in jump}:
            assert state in reachable(targets, targets[state]), text
    assert jumping > 50


def test_the_written_text_does_not_depend_on_earlier_translations() -> None:
    generator = random.Random("again")
    some = [random_formula(generator, ABC, MAX_SIZE) for _ in range(40)]
    first = [to_hoa(translate(formula, ABC)) for formula in some]
    again = [to_hoa(translate(formula, ABC)) for formula in reversed(some)]
    assert first == again[::-1]
