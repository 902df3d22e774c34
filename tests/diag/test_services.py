"""What other programs read: SARIF by its official schema, workflow commands by GitHub's rules."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tiloilc.diag import RULES, Diagnostic, Span, render
from tiloilc.diag.text import one_line
from tiloilc.driver import lint

SCHEMA = Path(__file__).parent / "assets" / "sarif-2.1.0-rtm.5.json"

texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=30)


@st.composite
def findings(draw: st.DrawFn) -> Diagnostic:
    """Findings with any text, at any place or none."""
    rule = RULES[draw(st.sampled_from(sorted(RULES)))]
    line, column = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    rows, columns = draw(st.integers(0, 2)), draw(st.integers(1, 5))
    file = draw(texts.filter(bool))
    span = Span(file, line, column, line + rows, (0 if rows else column) + columns)
    place = draw(st.sampled_from([span, None]))
    label, help = draw(texts), draw(texts)
    return Diagnostic(rule.code, rule.severity, draw(texts.filter(bool)), place, label, help)


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft4Validator:
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft4Validator.check_schema(schema)
    return jsonschema.Draft4Validator(schema, format_checker=jsonschema.FormatChecker())


def test_a_document_that_is_not_sarif_is_refused(validator: jsonschema.Draft4Validator) -> None:
    document = json.loads(render([Diagnostic.of("LTL210")], "sarif", {}))
    assert validator.is_valid(document)
    document["runs"][0]["results"][0]["level"] = "grave"
    assert not validator.is_valid(document)


def test_sarif_follows_the_official_schema(validator: jsonschema.Draft4Validator) -> None:
    @given(st.lists(findings(), max_size=4))
    def check(found: list[Diagnostic]) -> None:
        document = json.loads(render(found, "sarif", {}))
        validator.validate(document)
        assert _told(document) == {(d.code, d.span and d.span.file) for d in found}

    check()


def test_sarif_of_every_broken_spec_and_every_code_follows_the_schema(
    validator: jsonschema.Draft4Validator, root: Path
) -> None:
    found = [d for path in sorted((root / "tests/golden/specs").glob("*.yaml")) for d in lint(path)]
    assert len(found) > 10
    every = [Diagnostic(rule.code, rule.severity, rule.message) for rule in RULES.values()]
    for diagnostics in (found, every, []):
        validator.validate(json.loads(render(diagnostics, "sarif", {})))


def test_sarif_says_what_a_rule_means_and_where_to_read_on() -> None:
    document = json.loads(render([Diagnostic.of("LTL210")], "sarif", {}))
    (rule,) = document["runs"][0]["tool"]["driver"]["rules"]
    assert rule["fullDescription"]["text"].startswith("The formula contradicts itself")
    assert rule["help"]["markdown"].startswith("# error[LTL210]: unsatisfiable\n")
    assert "<!--" not in rule["help"]["markdown"]


def _told(document: Any) -> set[tuple[str, str | None]]:
    """Code and file of each result."""
    told = set()
    for result in document["runs"][0]["results"]:
        places = result.get("locations", [])
        file = places[0]["physicalLocation"]["artifactLocation"]["uri"] if places else None
        told.add((result["ruleId"], None if file is None else unquote(file)))
    return told


def understood(line: str) -> tuple[str, dict[str, str], str]:
    """A workflow command as GitHub's runner reads it: name, properties, message."""
    found = re.fullmatch(r"::(\w+) (.*?)::(.*)", line)
    assert found is not None, line
    properties = dict(pair.split("=", 1) for pair in found[2].split(","))
    decoded = {
        key: _decoded(value, ("%3A", ":"), ("%2C", ",")) for key, value in properties.items()
    }
    return found[1], decoded, _decoded(found[3])


def _decoded(text: str, *more: tuple[str, str]) -> str:
    for code, sign in (("%0D", "\r"), ("%0A", "\n"), *more, ("%25", "%")):
        text = text.replace(code, sign)
    return text


@given(findings())
def test_github_reads_back_what_we_say(finding: Diagnostic) -> None:
    (line,) = render([finding], "github", {}).removesuffix("\n").split("\n")
    assert "\r" not in line
    name, properties, message = understood(line)
    assert name == {"error": "error", "warning": "warning", "note": "notice"}[finding.severity]
    assert properties["title"] == finding.code
    assert message.split("\n")[0] == one_line(finding.message)
    if finding.span is not None:
        assert properties["file"] == finding.span.file
        assert properties["line"] == str(finding.span.line)


def test_github_escapes_as_its_toolkit_does() -> None:
    place = Span("a,b:c%.yaml", 3, 5, 3, 9)
    finding = Diagnostic("LTL203", RULES["LTL203"].severity, "50% of: a, b", place, help="use c")
    assert render([finding], "github", {}) == (
        "::error file=a%2Cb%3Ac%25.yaml,line=3,endLine=3,col=5,endColumn=9,title=LTL203"
        "::50%25 of: a, b%0Ahelp: use c\n"
    )
