import dataclasses
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plan.automata import chain, flatworld_cycle, response, stabilization
from tiloilc.automaton.ldba import Cube, Edge, Ldba
from tiloilc.diag import CompileError
from tiloilc.plan import (
    Plan,
    Predicate,
    automaton_json,
    digest,
    from_json,
    ldba_from_json,
    stage_plan,
    to_json,
)
from tiloilc.plan.canonical import LATER
from tiloilc.plan.options import is_partition
from tiloilc.spec import Demonstrations, Environment, Evaluate, Settings


def plan_for(ldba: Ldba) -> Plan:
    predicates = tuple(Predicate(name, text=f"x > {i}") for i, name in enumerate(ldba.propositions))
    return Plan(
        name="task",
        description="Grüße",
        environment=Environment(id="Some-v0", kwargs={"size": 3, "dt": 0.1}, horizon=50),
        fields={"x": (0, 1), "pos": (1, 3)},
        predicates=predicates,
        formula="G F r",
        ldba=ldba,
        stages=stage_plan(ldba),
        demonstrations=Demonstrations(source="expert", max_visits=2),
        train=Settings.model_validate({"algorithm": "tiloil", "preset": "paper", "steps": 100}),
        evaluate=Evaluate(every=10),
        digests={"spec:task.yaml": "0" * 64},
        version="0.1.0",
        root="../..",
    )


PLANS = [plan_for(ldba) for ldba in (flatworld_cycle(), stabilization(), chain("ab"), response())]


@pytest.mark.parametrize("plan", PLANS)
def test_a_plan_is_read_back_as_it_was(plan: Plan) -> None:
    assert from_json(to_json(plan)) == plan


@pytest.mark.parametrize("plan", PLANS)
def test_reading_and_writing_again_gives_the_same_bytes(plan: Plan) -> None:
    assert to_json(from_json(to_json(plan))) == to_json(plan)


def test_canonical_text_is_json_with_sorted_keys_and_ends_a_line() -> None:
    text = to_json(PLANS[0])
    keys = list(json.loads(text))
    assert keys == sorted(keys)
    assert text.endswith("}\n")
    assert "Grüße" in text
    assert '"index": [0, 1, 2, 3, 0]' in text


def test_the_digest_does_not_depend_on_where_the_task_file_is() -> None:
    plan = PLANS[0]
    assert digest(plan) == digest(dataclasses.replace(plan, root="/elsewhere"))
    assert digest(plan) != digest(dataclasses.replace(plan, formula="G F g"))


def test_every_setting_stands_in_the_plan_but_what_came_later() -> None:
    written = json.loads(to_json(PLANS[0]))["train"]
    assert set(written) == set(Settings.model_fields) - set(LATER)


@pytest.mark.parametrize("ldba", [flatworld_cycle(), stabilization(), chain("abc"), response()])
def test_automata_are_read_back_with_their_jumps(ldba: Ldba) -> None:
    assert ldba_from_json(automaton_json(ldba)) == ldba


def test_options_are_written_where_there_is_a_choice() -> None:
    rows = automaton_json(stabilization())["options"]
    assert rows == [{"state": 0, "targets": [0, 1], "guard": "y & !b", "cubes": [[3, 1]]}]
    assert automaton_json(flatworld_cycle())["options"] == []


def test_cubes_of_one_guard_may_overlap() -> None:
    guard = (Cube(1, 1), Cube(2, 2))
    edges = (Edge(0, 0, (Cube(3, 0),)), Edge(0, 1, guard), Edge(1, 1, (Cube(0, 0),)))
    ldba = Ldba(("a", "b"), ("wait", "true"), frozenset({1}), None, edges)
    assert ldba_from_json(automaton_json(ldba)) == ldba
    assert is_partition([guard, (Cube(3, 0),)])
    assert not is_partition([guard])
    assert not is_partition([guard, (Cube(1, 0),)])


def _changed(path: str, value: object) -> str:
    data = json.loads(to_json(PLANS[1]))
    *parents, last = path.split(".")
    place = data
    for key in parents:
        place = place[int(key)] if isinstance(place, list) else place[key]
    if value is None:
        del place[last]
    else:
        place[last] = value
    return json.dumps(data)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not JSON"),
        ("[" * 100_000, "nested too deeply"),
        ("[]", "no `schema_version`"),
        ('{"schema_version": 99}', "schema version is 99"),
        (_changed("name", None), "`name`: field required"),
        (_changed("surprise", 1), "`surprise`"),
        (_changed("train.gamma", None), "`train.gamma`: field required"),
        (_changed("train.gamma", 7), "gamma"),
        (_changed("automaton.edges.0.source", "0"), "`automaton.edges.0.source`"),
        (_changed("automaton.edges.0.target", 9), "not among its 3"),
        (_changed("automaton.accepting", [-1]), "not among its 3"),
        (_changed("automaton.edges.0.cubes", [[1, 2]]), "no set of letters"),
        (_changed("automaton.edges.0.cubes", [[0, 0]]), "do not partition letters"),
        (_changed("automaton.edges.0.guard", "y"), "contradict each other"),
        (_changed("automaton.options", []), "contradict each other"),
        (_changed("automaton.propositions", ["y", "y"]), "proposition twice"),
        (_changed("stages.index", [0, 1]), "do not fit the automaton"),
        (_changed("stages.length", [0, 1, 1]), "do not fit the automaton"),
        (_changed("fields.x", [1]), "two numbers"),
    ],
)
def test_a_damaged_plan_is_refused_with_a_reason(text: str, said: str) -> None:
    with pytest.raises(CompileError) as caught:
        from_json(text, "build/plan.json")
    (finding,) = caught.value.diagnostics
    assert finding.code == "PLAN407"
    assert said in finding.message
    assert finding.span is not None
    assert finding.span.file == "build/plan.json"


@settings(max_examples=150)
@given(st.data())
def test_no_damage_to_the_bytes_causes_any_other_error(data: st.DataObject) -> None:
    text = to_json(PLANS[1])
    start = data.draw(st.integers(0, len(text)))
    end = min(len(text), start + data.draw(st.integers(0, 8)))
    put = data.draw(st.sampled_from(["", "0", "-1", "9999999", '"', "null", "[]", "{}", "1e999"]))
    codes = []
    try:
        from_json(text[:start] + put + text[end:])
    except CompileError as error:
        codes = [d.code for d in error.diagnostics]
    assert set(codes) <= {"PLAN407"}


def test_a_plan_that_infers_once_is_written_as_before_one_could_infer_again() -> None:
    assert "inference_growth" not in to_json(PLANS[0])
    again = PLANS[0].train.override({"inference_growth": 1.5})
    growing = dataclasses.replace(PLANS[0], train=again)
    assert from_json(to_json(growing)) == growing


def test_a_plan_without_a_dataset_is_written_as_before_there_were_any() -> None:
    assert '"minari"' not in to_json(PLANS[0])
    wanted = Demonstrations(minari="walk-v0")
    named = dataclasses.replace(PLANS[0], demonstrations=wanted)
    assert from_json(to_json(named)) == named
