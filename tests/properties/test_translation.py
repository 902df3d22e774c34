"""The oracle of every pass: formula and automaton agree on random ultimately periodic words."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.properties.lasso import NAMES, Check, Words, random_check, reducing, rewriting
from tests.strategies import formulas, lassos, random_formula, random_lasso
from tiloilc.automaton import accepts, to_hoa, translate
from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.construction.implication import Implications
from tiloilc.automaton.construction.terms import Terms
from tiloilc.automaton.draft import Draft, reachable
from tiloilc.automaton.limits import Budget
from tiloilc.automaton.reduction.reduce import PASSES
from tiloilc.automaton.translate import ConstructionName
from tiloilc.ltl import Lasso, holds, parse, to_text
from tiloilc.ltl.ast import And, Formula, Or

ABC = ("a", "b", "c")
MAX_SIZE = 12

WORDS_PER_FORMULA = 10
FORMULAS = 200
"""In a series. All ten series are 20,000 pairs of a formula and a word, each looked at after every
pass; by hand ten times as many."""


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


@given(formulas(NAMES, 14), st.lists(lassos(NAMES), min_size=1, max_size=4))
def test_no_pass_changes_the_language(formula: Formula, some: list[Lasso]) -> None:
    assert Check(formula, Words(tuple(some), NAMES)).everything() == []


@pytest.mark.parametrize(
    "series",
    [
        range(1, 2),
        range(2, 3),
        pytest.param(range(1), marks=pytest.mark.slow),  # one formula takes half of its time
        pytest.param(range(3, 6), marks=pytest.mark.slow),
        pytest.param(range(6, 10), marks=pytest.mark.slow),
    ],
    ids=lambda series: " ".join(map(str, series)),
)
def test_no_pass_changes_the_language_of_many_formulas(series: range) -> None:
    seen: Counter[str] = Counter()
    true = 0
    for one, number in product(series, range(FORMULAS)):
        check = random_check(one, number, WORDS_PER_FORMULA)
        assert check.everything() == [], to_text(check.formula)
        seen += check.seen
        true += sum(check.truth)
    assert 0.3 < true / (len(series) * FORMULAS * WORDS_PER_FORMULA) < 0.7
    assert {f"pass {step.__name__}" for step in PASSES} - RARE <= seen.keys(), "all had work to do"


@pytest.mark.parametrize("construction", ["asymmetric", "symmetric"])
@pytest.mark.parametrize(
    ("text", "stem", "loop"),
    [
        ("F (!c & F (X c -> a) W (a | !G b))", (6, 2), (6, 6)),
        ("c W b & c R F (b <-> F c)", (), (3, 2)),
        ("X b ^ c | (c | X (c | c)) R F (a | a W c)", (), (0,)),
        ("a | (c | X b) R F (a | c R b)", (), (0,)),
        ("F (X b & F (b | a) W (a | a & c & c))", (0, 2), (4,)),
        ("X (X a ^ a) M (F (c | a | a) W c)", (3, 2, 3, 2), (2,)),
    ],
)
def test_what_is_kept_for_ever_is_guessed_in_the_form_in_which_it_is_kept(
    text: str, stem: tuple[int, ...], loop: tuple[int, ...], construction: ConstructionName
) -> None:
    """p W c that is left over is kept by G (p & !c), where !c is known of p."""
    formula = parse(text, ABC).formula
    assert not holds(formula, Lasso(stem, loop), ABC)
    assert not accepts(translate(formula, ABC, construction=construction), Lasso(stem, loop))


RARE = {"pass cut_exits"}
"""What has no work to do in thousands of random formulas."""


@pytest.mark.parametrize("inner", ["c", "c | X a", "G c", "c W a"])
def test_jumps_lead_to_where_one_stays(inner: str) -> None:
    generator = random.Random(inner)
    formula = parse(f"F (a & (b R (!b R (b R ({inner})))))", ABC).formula
    some = [random_lasso(generator, ABC) for _ in range(300)]
    some += [Lasso(word.stem, tuple(x | 0b100 for x in word.loop)) for word in some]
    check = Check(formula, Words(tuple(some), ABC))
    assert check.everything() == []
    assert check.seen.keys() >= RARE or inner != "c"
    assert 50 < sum(check.truth) < 550


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
    "F (a & (({0}) R (!({0}) R (({0}) R ({1})))))",
    "G (a | (!b & c) U (b | ({0}) | (G c | !c W ({1}))))",
    "({0}) M (({1}) W c)",
    "({0}) | (c | {1}) R F (a | {2})",
    "X ({0}) & ((F ({1}) | G ({2})) W c)",
    "(!c | {0}) R (({1}) R ({2}))",
)
"""Shapes that need the general construction, or of which one part implies another."""


@pytest.mark.parametrize("template", TEMPLATES)
def test_no_pass_changes_the_language_of_formulas_that_need_jumps(template: str) -> None:
    generator = random.Random(template)
    for _ in range(25):
        parts = [to_text(random_formula(generator, ABC, 5)) for _ in range(3)]
        formula = parse(template.format(*parts), ABC).formula
        some = tuple(random_lasso(generator, ABC) for _ in range(WORDS_PER_FORMULA))
        assert Check(formula, Words(some, ABC)).everything() == [], to_text(formula)


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


def all_marked(draft: Draft, diagrams: Diagrams) -> Draft:
    """Wrong: every edge accepts."""
    rows = tuple(
        {(target, True): guard for (target, _), guard in row.items()} for row in draft.rows
    )
    return replace(draft, rows=rows)


def jumpless(draft: Draft, diagrams: Diagrams) -> Draft:
    """Wrong: nothing is guessed."""
    return replace(draft, jumps=((),) * len(draft.jumps))


def conjunctive(formula: Formula) -> Formula:
    """Wrong: or is and."""
    return And(formula.operands) if isinstance(formula, Or) else formula


@pytest.mark.parametrize(
    ("module", "passes", "wrong"),
    [
        (reducing, "PASSES", all_marked),
        (reducing, "PASSES", jumpless),
        (rewriting, "RULES", conjunctive),
    ],
)
def test_the_oracle_notices_a_wrong_pass_and_names_it(
    module: object, passes: str, wrong: Callable[..., object]
) -> None:
    with patch.object(module, passes, (*getattr(module, passes), wrong)):
        found = [random_check(3, number, 10).everything() for number in range(75)]
    first = [names[0] for names in found if names]
    named = [name for name in first if name.endswith(wrong.__name__)]
    assert len(named) > 3
    assert set(first) - set(named) <= {"HOA in, default"}, "on no word, but it is no LDBA any more"
