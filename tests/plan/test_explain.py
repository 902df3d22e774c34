import dataclasses

from tests.plan.test_canonical import PLANS
from tiloilc.automaton import translate
from tiloilc.ltl import Lasso, parse
from tiloilc.plan import stage_plan
from tiloilc.plan.explain import explain, kind_of, word_text


def test_a_plan_is_explained_with_formula_stages_and_words() -> None:
    text = "F G y & G !b"
    ldba = translate(parse(text, ("y", "b")).formula, ("y", "b"))
    plan = dataclasses.replace(PLANS[1], formula=text, ldba=ldba, stages=stage_plan(ldba))
    said = explain(plan)
    assert "with all brackets: (F G y) & (G !b)" in said
    assert "may lead to 1, by an ε-jump" in said
    assert "b violates for ever" in said
    assert "f_0: segments that got to 1, against those that got to 0 or a violation" in said
    assert "accepted: " in said
    assert "rejected: " in said


def test_words_are_written_as_sets() -> None:
    assert word_text(Lasso((1, 0), (3,)), ("a", "b")) == "{a} {} then for ever {a, b}"
    assert word_text(Lasso((), (2,)), ("a", "b")) == "for ever {b}"


def test_the_class_of_a_formula_is_named() -> None:
    kinds = {
        "G !a": "safety",
        "F (a & X F b)": "co-safety",
        "G F a": "deterministic Büchi",
        "F G a": "beyond deterministic",
    }
    for text, kind in kinds.items():
        parsed = parse(text)
        assert kind_of(parsed.formula, translate(parsed.formula, parsed.propositions)).startswith(
            kind
        )
