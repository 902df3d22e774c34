import random
from pathlib import Path

import pytest

from tests.strategies import random_lasso
from tiloilc.ltl import holds, nnf, parse, propositions_of, simplify, to_text
from tiloilc.ltl.rewrite import RULES, Rule

FIXTURES = Path(__file__).parent / "rules"


def pairs(rule: Rule) -> list[tuple[str, str]]:
    lines = (FIXTURES / f"{rule.__name__}.txt").read_text(encoding="utf-8").splitlines()
    split = [line.split(" ≡ ") for line in lines if not line.startswith("#")]
    return [(before, after) for before, after in split]


CASES = [(rule, before, after) for rule in RULES for before, after in pairs(rule)]


@pytest.mark.parametrize(("rule", "before", "after"), CASES)
def test_a_rule_rewrites_its_examples_and_leaves_its_counterexamples(
    rule: Rule, before: str, after: str
) -> None:
    assert to_text(rule(parse(before).formula)) == after


@pytest.mark.parametrize(("rule", "before", "after"), CASES)
def test_both_sides_of_an_example_mean_the_same(rule: Rule, before: str, after: str) -> None:
    left, right = parse(before).formula, parse(after).formula
    names = propositions_of(left)
    generator = random.Random(0)
    for _ in range(200):
        word = random_lasso(generator, names)
        assert holds(left, word, names) == holds(right, word, names)


@pytest.mark.parametrize("rule", RULES)
def test_every_rule_has_examples_that_change_and_one_that_does_not(rule: Rule) -> None:
    changed = [parse(before).formula != parse(after).formula for before, after in pairs(rule)]
    assert any(changed)
    assert not all(changed)


def test_every_fixture_belongs_to_a_rule() -> None:
    assert {path.stem for path in FIXTURES.iterdir()} == {rule.__name__ for rule in RULES}


@pytest.mark.parametrize(
    "text",
    [
        "G F (a & X F (b & X F (c & X F d))) & G !z",
        "F (a & X F (b & X F c))",
        "F G y & G !b",
        "(F (y & X F g) | F (r & X F g)) & G !b",
        "F grasp & G F (goal & X F button)",
        "(!tray | F (grasp & X F intray)) & (tray | F (grasp & X F ingoal))",
    ],
)
def test_the_written_order_of_a_chain_is_kept(text: str) -> None:
    wanted = text.replace("(F (y & X F g) | F (r & X F g))", "F (y & X F g | r & X F g)")
    assert to_text(simplify(parse(text).formula)) == wanted


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("G F a & G F b & G (a -> F b)", "G F a & G F b"),
        ("!(a U !(a U b))", "!a R (a U b)"),
        ("F a <-> F a", "true"),
        ("G F X a", "G F a"),
        ("G (a U b)", "G (a | b) & G F b"),
        ("F (a U (b U c))", "F c"),
    ],
)
def test_rules_work_together(text: str, wanted: str) -> None:
    assert to_text(simplify(parse(text).formula)) == wanted


def test_a_simple_formula_stays_what_it_is() -> None:
    formula = simplify(parse("a U (b & X c) | G d").formula)
    assert simplify(formula) == formula


def test_a_tower_of_equivalences_does_not_explode() -> None:
    formula = parse(" <-> ".join(["a", "b", "c"] * 30)).formula
    assert simplify(formula) == nnf(formula)
