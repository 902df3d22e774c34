"""The task file: what is read, and what is said about what cannot be."""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import pytest
from ruamel.yaml import YAML

from tiloilc.diag import CompileError, Diagnostic, Span, render
from tiloilc.spec import PythonPredicate, Spec, examine_text, json_schema, read_spec
from tiloilc.spec.presets import PAPER
from tiloilc.spec.settings import Settings

GOOD = """\
name: demo
environment:
  id: some:Env-v0
  kwargs: {size: 3, names: [a, b]}
  horizon: 50
observation:
  pos: [0, 2]
  speed: 4
propositions:
  b: norm(pos) < 1
  a: {python: "labels.py:fast"}
formula: "F (a & X F b)"
train:
  steps: 60_000
  beta: 1/3
"""


def changed(old: str, new: str) -> str:
    assert old in GOOD
    return GOOD.replace(old, new)


def examined(yaml: str) -> tuple[Spec | None, tuple[Diagnostic, ...]]:
    _, spec, findings = examine_text(yaml, "f.yaml")
    return spec, findings


def only(yaml: str) -> Diagnostic:
    _, (finding,) = examined(yaml)
    return finding


def marked(yaml: str, diagnostic: Diagnostic) -> str:
    span = diagnostic.span
    assert span is not None
    return yaml.split("\n")[span.line - 1][span.column - 1 : span.end_column - 1]


def test_a_good_file_is_read_as_written() -> None:
    spec, findings = examined(GOOD)
    assert findings == ()
    assert spec is not None
    assert list(spec.propositions) == ["b", "a"]
    assert spec.propositions["a"] == PythonPredicate(python="labels.py:fast")
    assert spec.environment.kwargs == {"size": 3, "names": ["a", "b"]}
    assert spec.fields == {"pos": (0, 2), "speed": (4, 5)}
    assert (spec.train.steps, spec.train.beta) == (60_000, 1 / 3)
    assert spec.demonstrations is None
    assert spec.evaluate.episodes == 20


@pytest.mark.parametrize(
    "steps", ["60000", "60_000", "6e4", "60000.0", "'60000'", "120000/2", "6.0e+4"]
)
def test_numbers_are_taken_as_people_write_them(steps: str) -> None:
    spec, findings = examined(changed("60_000", steps))
    assert findings == ()
    assert spec is not None
    assert spec.train.steps == 60_000


def test_text_stays_text_whatever_it_looks_like() -> None:
    yaml = changed('"F (a & X F b)"', "true").replace("norm(pos) < 1", "1").replace("demo", "2026")
    spec, findings = examined(yaml)
    assert findings == ()
    assert spec is not None
    assert (spec.name, spec.formula, spec.propositions["b"]) == ("2026", "true", "1")


def test_a_formula_in_a_block_is_read() -> None:
    spec, _ = examined(changed('"F (a & X F b)"', ">-\n  F (a &\n  X F b)"))
    assert spec is not None
    assert spec.formula == "F (a & X F b)"


WRONG = [
    ("horizon: 50", "horzon: 50", "SPEC101", "horzon", "unknown key `environment.horzon`"),
    ("  steps:", "  seps: 3\n  steps:", "SPEC101", "seps", "unknown key `train.seps`"),
    ("train:", "trian: 1\ntrain:", "SPEC101", "trian", "unknown key `trian`"),
    ('"labels.py:fast"', "a.py:f, x: 1", "SPEC101", "x", "unknown key `propositions.a.x`"),
    ("  horizon: 50\n", "", "SPEC102", "environment", "missing key `environment.horizon`"),
    ("  steps: 60_000\n", "", "SPEC102", "train", "missing key `train.steps`"),
    ("name: demo\n", "", "SPEC102", "e", "missing key `name`"),
    ('{python: "labels.py:fast"}', "{}", "SPEC102", "a", "missing key `propositions.a.python`"),
    ("60_000", "lots", "SPEC103", "lots", "must be a whole number, not `lots`"),
    ("60_000", "true", "SPEC103", "true", "must be a whole number, not `true`"),
    ("60_000", "1/3", "SPEC103", "1/3", "must be a whole number, not `1/3`"),
    ("60_000", ".nan", "SPEC103", ".nan", "must be a finite number, not `.nan`"),
    ("60_000", "0", "SPEC103", "0", "must be greater than 0, not `0`"),
    ("60_000", "[1]", "SPEC103", "[1]", "must be a whole number, not a list"),
    ("60_000", "", "SPEC103", "steps", "`train.steps` is empty"),
    ("1/3", "1/0", "SPEC103", "1/0", "must be a number, not `1/0`"),
    ("1/3", ".inf", "SPEC103", ".inf", "must be a finite number, not `.inf`"),
    ("beta: 1/3", "preset: papr", "SPEC103", "papr", "must be `default` or `paper`, not `papr`"),
    ("beta: 1/3", "entropy: low", "SPEC103", "low", "must be `tuned` or a number, not `low`"),
    ("beta: 1/3", "segment: perhaps", "SPEC103", "perhaps", "must be true or false"),
    ("beta: 1/3", "actor_hidden: [8, x]", "SPEC103", "x", "`train.actor_hidden[1]` must be"),
    ("beta: 1/3", "actor_hidden: []", "SPEC103", "[]", "must not be empty"),
    ("beta: 1/3", "actor_hidden: 8", "SPEC103", "8", "must be a list, not `8`"),
    ("id: some:Env-v0", "id: [a]", "SPEC103", "[a]", "must be text, not a list"),
    ("id: some:Env-v0", 'id: ""', "SPEC103", "id", "must not be empty"),
    ("name: demo", "name: a/b", "SPEC103", "a/b", "must be a name of ASCII letters"),
    ("name: demo", "name: _x", "SPEC103", "_x", "`.`, the first a letter or digit, not `_x`"),
    ("name: demo", f"name: {'x' * 101}", "SPEC103", "x" * 101, "text of at most 100 characters"),
    ("pos: [0, 2]", "pos: [2, 0]", "SPEC103", "[2, 0]", "must be an index like 4"),
    ("pos: [0, 2]", "pos: [0]", "SPEC103", "[0]", "must be an index like 4"),
    ("pos: [0, 2]", "pos: -1", "SPEC103", "-1", "must be an index like 4"),
    ("pos: [0, 2]", "my pos: 1", "SPEC103", "my pos", "is not a name that predicates can use"),
    ("norm(pos) < 1", "", "SPEC103", "b", "`propositions.b` is empty"),
    ("norm(pos) < 1", '" "', "SPEC103", "b", "`propositions.b` is empty"),
    ("norm(pos) < 1", "[1, 2]", "SPEC104", "[", "`[` is read as a list"),
    ('"F (a & X F b)"', "", "SPEC103", "formula", "`formula` is empty"),
    ('"F (a & X F b)"', "!a U b", "SPEC104", "!a", "`!a` is read as a tag"),
    ('formula: "F (a & X F b)"\n', "", "SPEC108", "n", "needs one of `formula` and `automaton`"),
    ("formula:", "automaton: x.hoa\nformula:", "SPEC108", "automaton", "exclude each other"),
    ("train:", "demonstrations: {}\ntrain:", "SPEC108", "demonstrations", "needs one of `source`"),
    ("train:", "evaluate: 5\ntrain:", "SPEC103", "5", "must be a mapping of keys to values"),
    ("  b: norm", '  "true": norm', "SPEC121", '"true"', "`true` cannot name a proposition"),
    ("  b: norm", "  'a\"b': norm", "SPEC121", "'a\"b'", "cannot name a proposition"),
    ("name: demo", "name: demo\nname: x", "SPEC107", "name", "duplicate key `name`"),
]


@pytest.mark.parametrize(
    ("old", "new", "code", "piece", "message"), WRONG, ids=[w[1] for w in WRONG]
)
def test_a_mistake_is_one_finding_at_its_place(
    old: str, new: str, code: str, piece: str, message: str
) -> None:
    yaml = changed(old, new)
    finding = only(yaml)
    assert finding.code == code
    assert message in finding.message
    assert marked(yaml, finding) == piece


NUMBERS = [
    ("train", name)
    for name in Settings.model_fields
    if name != "beta" and type(PAPER.get(name, 1)) in (int, float, tuple)
] + [
    ("environment", "horizon"),
    ("demonstrations", "count"),
    ("demonstrations", "max_visits"),
    ("demonstrations", "max_steps"),
    ("evaluate", "episodes"),
    ("evaluate", "every"),
]


@pytest.mark.parametrize(("section", "key"), NUMBERS, ids=[key for _, key in NUMBERS])
def test_every_number_has_a_limit_beyond_which_it_is_a_finding_at_its_place(
    section: str, key: str
) -> None:
    """A slip of the finger is no memory error (β has a finding of its own, PLAN404)."""
    given = f"[{'9' * 15}]" if key.endswith("_hidden") else "9" * 15
    yaml = f"{section}: {{{key}: {given}}}\n"
    (finding,) = (f for f in examined(yaml)[1] if key in f.message)
    assert finding.code == "SPEC103"
    assert re.search(r"must be .*at most [\d,.]+, not", finding.message)
    assert marked(yaml, finding) == "9" * 15


def test_no_finding_speaks_pydantic() -> None:
    jargon = (
        "pydantic",
        "https://",
        "Input should",
        "validation",
        "type=",
        "str |",
        "int_",
        "dict",
    )
    for old, new, *_ in WRONG:
        yaml = changed(old, new)
        text = render(examined(yaml)[1], "text", {"f.yaml": yaml})
        assert [word for word in jargon if word in text] == []


def test_misspelt_keys_and_values_get_the_right_one_offered() -> None:
    assert only(changed("horizon:", "horzon:")).help == "did you mean `horizon`?"
    assert only(changed("beta: 1/3", "preset: papr")).help == "did you mean `paper`?"
    assert only(changed("train:", "zzz: 1\ntrain:")).help.startswith("known: name, description")


def test_all_independent_mistakes_are_found_in_one_go_in_order() -> None:
    yaml = """\
name: a b
colour: red
environment: {id: x, horizon: -1}
propositions:
  p: &q
formula: !p
automaton: y
train: {steps: x, steps: 2, beta: z}
"""
    _, findings = examined(yaml)
    assert [(f.code, f.span.line if f.span else 0) for f in findings] == [
        ("SPEC103", 1),
        ("SPEC101", 2),
        ("SPEC103", 3),
        ("SPEC104", 5),
        ("SPEC104", 6),
        ("SPEC108", 7),
        ("SPEC103", 8),
        ("SPEC107", 8),
        ("SPEC103", 8),
    ]


def test_a_swallowed_formula_is_still_known_as_it_was_meant() -> None:
    document, _, _ = examine_text(changed('"F (a & X F b)"', "!a U b   # c"), "f.yaml")
    text = document.value_text("formula")
    assert text.value == "!a U b"
    assert text.span(5, 6).column == 15


def test_too_many_propositions_are_a_finding() -> None:
    many = "".join(f"  p{i}: true\n" for i in range(63))
    assert only(changed("  b: norm(pos) < 1\n", many)).code == "SPEC122"


@pytest.mark.parametrize(
    ("yaml", "kind"),
    [("", "an empty file"), ("# x\n", "an empty"), ("- a\n", "a list"), ("a", "a single value")],
)
def test_what_is_no_mapping_is_no_task_file(yaml: str, kind: str) -> None:
    with pytest.raises(CompileError, match=rf"SPEC106.*{kind}"):
        examine_text(yaml, "f.yaml")


@pytest.mark.parametrize(
    ("file", "says", "place"),
    [
        ("nope.yaml", "there is no such file", (1, 1)),
        ("folder", "it is a folder", (1, 1)),
        ("latin.yaml", "not UTF-8 text", (2, 10)),
    ],
)
def test_a_file_that_cannot_be_read_says_why_and_is_where_the_finding_is(
    workdir: Path, file: str, says: str, place: tuple[int, int]
) -> None:
    Path("folder").mkdir()
    Path("latin.yaml").write_bytes(b"# here\nname: caf\xe9\n")
    with pytest.raises(CompileError, match=f"SPEC105.*{says}") as raised:
        read_spec(file)
    assert raised.value.diagnostics[0].span == Span.at(file, *place)


def test_read_spec_gives_places_and_raises_with_every_finding(workdir: Path) -> None:
    Path("good.yaml").write_text("\ufeff" + GOOD, encoding="utf-8")
    file = read_spec("good.yaml")
    assert (file.file, file.path) == ("good.yaml", Path("good.yaml"))
    text = file.value_text("formula")
    assert text.value == "F (a & X F b)"
    assert (text.span(3, 4).line, text.span(3, 4).column) == (12, 14)
    assert file.span("train", "beta").column == 9
    assert file.key_span("train", "beta").column == 3
    assert file.keys("propositions") == ("b", "a")
    assert file.has("train", "beta")
    assert not file.has("train", "tau")
    Path("bad.yaml").write_text(changed("60_000", "lots").replace("1/3", "x"))
    with pytest.raises(CompileError) as caught:
        read_spec("bad.yaml")
    assert [d.code for d in caught.value.diagnostics] == ["SPEC103", "SPEC103"]


def test_the_place_of_what_is_not_said_is_where_it_belongs(workdir: Path) -> None:
    Path("good.yaml").write_text(GOOD)
    file = read_spec("good.yaml")
    assert file.span("train", "tau") == file.key_span("train")
    assert file.span("demonstrations", "file").line == 1
    with pytest.raises(KeyError):
        file.value_text("train", "tau")


def test_the_schema_takes_every_spec_of_the_project_and_the_good_file(root: Path) -> None:
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    loader = YAML(typ="safe", pure=True)
    files = sorted((root / "specs").glob("*.yaml"))
    assert files
    for text in (GOOD, *(file.read_text(encoding="utf-8") for file in files)):
        validator.validate(loader.load(text))
        assert examined(text)[1] == ()


def test_editors_find_the_schema_of_today_beside_every_spec_of_the_project(root: Path) -> None:
    """`tiloilc schema > specs/spec.schema.json` writes it anew."""
    shipped = (root / "specs" / "spec.schema.json").read_text(encoding="utf-8")
    assert json.loads(shipped) == json_schema()
    for file in (root / "specs").glob("*.yaml"):
        first = file.read_text(encoding="utf-8").partition("\n")[0]
        assert first == "# yaml-language-server: $schema=spec.schema.json"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("horizon:", "horzon:"),
        ("60_000", "lots"),
        ("60_000", "0"),
        ("name: demo", "name: a/b"),
        ('formula: "F (a & X F b)"', ""),
        ("formula:", "automaton: x\nformula:"),
    ],
)
def test_the_schema_refuses_what_reading_refuses(old: str, new: str) -> None:
    document = YAML(typ="safe", pure=True).load(changed(old, new))
    assert not jsonschema.Draft202012Validator(json_schema()).is_valid(document)


def test_every_key_of_the_schema_is_described() -> None:
    schema = json_schema()
    for model in (schema, *schema["$defs"].values()):
        for key, about in model.get("properties", {}).items():
            assert about.get("description") or "$ref" in about, key
