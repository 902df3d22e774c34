import dataclasses
from pathlib import Path

import pytest

from tests.plan.automata import stabilization
from tests.plan.test_canonical import PLANS
from tiloilc.automaton import translate
from tiloilc.driver import compile_spec
from tiloilc.ltl import parse
from tiloilc.plan import stage_plan
from tiloilc.plan.explain import explain, kind_of

ROOT = Path(__file__).resolve().parents[2]
SPECS, GOLDEN = ROOT / "specs", ROOT / "tests" / "golden" / "explain"


def test_a_plan_is_explained_with_formula_stages_and_words() -> None:
    text = "F G y & G !b"
    ldba = translate(parse(text, ("y", "b")).formula, ("y", "b"))
    plan = dataclasses.replace(PLANS[1], formula=text, ldba=ldba, stages=stage_plan(ldba))
    said = explain(plan)
    assert "with all brackets: (F G y) & (G !b)" in said
    assert "or decide for state 1, that from here on G y & G !b (ε-jump)" in said
    assert "touching b loses for ever" in said
    assert "f_0: segments that got to 1, against those that got to 0 or a violation" in said
    assert "accepted: " in said
    assert "rejected: " in said


def test_where_nothing_can_be_lost_nothing_is_said_of_violations() -> None:
    text = "F (a & X F b)"
    ldba = translate(parse(text, ("a", "b")).formula, ("a", "b"))
    plan = dataclasses.replace(PLANS[1], formula=text, ldba=ldba, stages=stage_plan(ldba))
    assert "f_1: segments that got to 2, against those that got to 0 or 1\n" in explain(plan)


def test_an_automaton_from_a_file_is_explained_without_a_formula() -> None:
    ldba = stabilization()
    files = {"spec:a.yaml": "0", "automaton:mine.hoa": "1"}
    about = dataclasses.replace(PLANS[1], formula="", ldba=ldba, stages=stage_plan(ldba))
    said = explain(dataclasses.replace(about, digests=files))
    assert "\nAutomaton\n  from the file mine.hoa\n" in said
    assert "named: state 0" in said
    assert "left to do" not in said
    assert "accepted: for ever {y}" in said


@pytest.mark.parametrize("path", sorted(SPECS.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_explanation_of_each_task_is_the_one_that_was_looked_at(path: Path) -> None:
    """`python -m tests.plan.test_explain` writes them anew, to be looked at."""
    assert explain(compile_spec(path).plan) == (GOLDEN / f"{path.stem}.txt").read_text("utf-8")


def test_the_class_of_a_formula_is_named() -> None:
    kinds = {
        "G !a": "safety",
        "F (a & X F b)": "guarantee: something good happens once (co-safety)",
        "G F a": "recurrence",
        "F G a": "persistence",
    }
    for text, kind in kinds.items():
        parsed = parse(text)
        assert kind_of(parsed.formula, translate(parsed.formula, parsed.propositions)).startswith(
            kind
        )


if __name__ == "__main__":
    for spec in sorted(SPECS.glob("*.yaml")):
        told = explain(compile_spec(spec).plan)
        (GOLDEN / f"{spec.stem}.txt").write_text(told, encoding="utf-8")
