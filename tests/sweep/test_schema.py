"""The JSON Schema of sweep files says what reading says, as far as one file can tell."""

from __future__ import annotations

import json
import re
from typing import Any

import jsonschema
import pytest
from ruamel.yaml import YAML

from tests.conftest import ROOT
from tiloilc.diag import Diagnostic
from tiloilc.spec.read import examine_document, read_document
from tiloilc.sweep import sweep_schema
from tiloilc.sweep.model import SWEEP_FILE

FILES = sorted((ROOT / "sweeps").glob("*.yaml"))

GOOD = """\
specs: ["grid_*.yaml"]
algorithms: [tiloil, cloning]
steps: 200_000
seeds: 1e1
overrides: [{}, {beta: 1/3, actor_hidden: [64, 64], demonstrations.max_visits: }]
grid: {gamma: [0.9, 99/100], segment: [true, false], demonstrations.count: [5, 1_0]}
"""


def loaded(text: str) -> Any:
    return YAML(typ="safe", pure=True).load(text)


def refused(text: str) -> tuple[Diagnostic, ...]:
    """What reading finds wrong, before it looks for the specs."""
    document, found = read_document(text, "sweep.yaml", SWEEP_FILE)
    return examine_document(document, SWEEP_FILE, found)[1]


def validator() -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(sweep_schema())


def test_the_schema_takes_every_sweep_of_the_project_and_of_the_readme() -> None:
    jsonschema.Draft202012Validator.check_schema(sweep_schema())
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = re.findall(r"^```yaml\n(specs:.*?)^```$", readme, re.MULTILINE | re.DOTALL)
    assert shown
    for text in (GOOD, *shown, *(file.read_text(encoding="utf-8") for file in FILES)):
        validator().validate(loaded(text))
        assert refused(text) == ()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("specs:", "spec:"),
        ('["grid_*.yaml"]', "[]"),
        ("[tiloil, cloning]", "tiloil"),
        ("[tiloil, cloning]", "[a/b]"),
        ("200_000", "0"),
        ("1e1", "many"),
        ("beta: 1/3", "bta: 1/3"),
        ("beta: 1/3", "beta: -1"),
        ("beta: 1/3", "beta:"),
        ("beta: 1/3", "seeds: 1"),
        ("gamma: [0.9, 99/100]", "gamma: 0.9"),
        ("gamma: [0.9, 99/100]", "gamma: [0.9, 2]"),
        ("gamma: [0.9, 99/100]", "gamma: []"),
        ("demonstrations.count: [5, 1_0]", "demonstrations.count: [5, -1]"),
        ("demonstrations.count: [5, 1_0]", "demonstrations.cuont: [5]"),
        ("demonstrations.count: [5, 1_0]", "demonstrations.source: [experts]"),
        ("demonstrations.max_visits: ", "demonstrations.file: "),
    ],
)
def test_the_schema_refuses_what_reading_refuses(old: str, new: str) -> None:
    assert old in GOOD
    text = GOOD.replace(old, new)
    assert refused(text)
    assert not validator().is_valid(loaded(text))


def test_editors_find_the_schema_of_today_beside_every_sweep_of_the_project() -> None:
    """`tiloilc schema sweep > sweeps/sweep.schema.json` writes it anew."""
    shipped = (ROOT / "sweeps" / "sweep.schema.json").read_text(encoding="utf-8")
    assert json.loads(shipped) == sweep_schema()
    for file in FILES:
        first = file.read_text(encoding="utf-8").partition("\n")[0]
        assert first == "# yaml-language-server: $schema=sweep.schema.json"


def test_every_key_of_the_schema_is_described_and_has_no_default_of_its_own() -> None:
    schema = sweep_schema()
    for model in (schema, *schema["$defs"].values()):
        for key, about in model["properties"].items():
            assert about["description"], key
            assert model is schema or "default" not in about, key
