"""YAML's own trouble, in words that help: syntax, swallowed formulas, duplicates, bombs."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tiloilc.diag import CompileError, Diagnostic, render
from tiloilc.spec.compose import compose
from tiloilc.spec.nodes import MappingNode, Scalar, Source, find, scalar_value


def findings(yaml: str) -> list[Diagnostic]:
    try:
        return compose(Source(yaml, "f"))[1]
    except CompileError as error:
        return list(error.diagnostics)


def marked(yaml: str, diagnostic: Diagnostic) -> str:
    span = diagnostic.span
    assert span is not None
    assert span.line == span.end_line
    return yaml.split("\n")[span.line - 1][span.column - 1 : span.end_column - 1]


SWALLOWED = [
    ("!b", "!b"),
    ("!b & F a", "!b"),
    ("!(a | b)", "!(a"),
    ("! a", "!"),
    ("!", "!"),
    ("&a", "&a"),
    ("&a | b", "&a"),
    ("& a", "&"),
    ("*a", "*a"),
    ("*a & b", "*a"),
    ("[]a", "[]"),
    ("[] a & b", "[]"),
    ("[1, 2] < 3", "["),
    ("| a", "|"),
    ("> 0", ">"),
    ("% 2", "%"),
    ("@a", "@"),
    ("{a} | b", "{"),
    ("!b   # never", "!b"),
]


@pytest.mark.parametrize(("value", "piece"), SWALLOWED, ids=[v for v, _ in SWALLOWED])
@pytest.mark.parametrize("before", ["formula: ", "name: x\npropositions:\n  p: "])
def test_a_formula_that_yaml_swallows_is_to_be_quoted(before: str, value: str, piece: str) -> None:
    yaml = f"{before}{value}\nz: 1\n"
    (finding,) = findings(yaml)
    assert finding.code == "SPEC104"
    assert marked(yaml, finding) == piece
    text = value.removesuffix("   # never")
    assert finding.help.endswith(f'"{text}"')


def test_the_quoted_formula_of_the_help_line_is_read() -> None:
    (finding,) = findings("formula: !b & F a\n")
    root, found = compose(Source(finding.help.removeprefix("quote it: "), "f"))
    assert found == []
    assert root is not None
    node = find(root, ("formula",))
    assert isinstance(node, Scalar)
    assert node.text.value == "!b & F a"


def test_several_swallowed_predicates_are_all_found() -> None:
    yaml = "propositions:\n  a: !x\n  b: &y\n  c: x > 0\nformula: !z\n"
    assert [marked(yaml, f) for f in findings(yaml)] == ["!x", "&y", "!z"]


def test_ordinary_yaml_is_left_alone() -> None:
    for yaml in (
        'formula: "!a"\n',
        "formula: >-\n  !a &\n  b\n",
        "formula: <>a\n",
        "formula: a | b & c\n",
        "train: &t {steps: 1}\nother: *t\n",
        "steps: &n 5\nmore: *n\n",
        "propositions:\n  p: {python: 'f.py:g'}\n",
        "formula: &f 'F a'\n",
    ):
        assert findings(yaml) == [], yaml


SYNTAX = [
    ("formula: G F a: b\n", ":", "a `:` stands where no key can be"),
    ('a: 1\nb: "abc\nc: d\n', '"', "a quote is never closed"),
    ("b: 'abc\nc: d\n", "'", "a quote is never closed"),
    ("\ta: b\n", "\t", "a tab cannot indent"),
    ("a: [1, 2\nb: 3\n", "[", "a list is not closed"),
    ("a: [1, 2\n", "[", "a list is not closed"),
    ("a: {b: c\n", "{", "a mapping is not closed"),
    ("a:\n  b: c\n d: e\n", "d", "this line does not fit the lines above"),
    ('a: "F b" & c\n', "& c", "text follows a closing quote"),
    ("a: 'F b' c\n", "c", "text follows a closing quote"),
    ('a: "b\\qc"\n', "q", "double quotes know no such escape"),
    ("a: b\n---\nc: d\n", "---", "a task file is one document"),
    ("[a, b]: c\n", "[a, b]", "a key is a single word, not a list"),
    ("a: \x07\n", "\x07", "a control character (U+0007)"),
]


@pytest.mark.parametrize(("yaml", "piece", "message"), SYNTAX, ids=[m for _, _, m in SYNTAX])
def test_broken_yaml_is_one_finding_at_its_cause(yaml: str, piece: str, message: str) -> None:
    (finding,) = findings(yaml)
    assert finding.code == "SPEC100"
    assert message in finding.message
    assert marked(yaml, finding) == piece


def test_each_duplicate_key_names_the_place_of_the_first() -> None:
    yaml = "a: 1\nb:\n  c: 1\n  c: 2\n'a': 3\n"
    first, second = findings(yaml)
    assert (first.code, first.message) == ("SPEC107", "duplicate key `b.c`")
    assert first.label == "first given in line 3, column 3"
    assert marked(yaml, second) == "'a'"
    assert second.label == "first given in line 1, column 1"


def test_merged_keys_are_overridden_and_are_no_duplicates() -> None:
    yaml = "base: &b {x: 1, y: 2}\nmine:\n  y: 3\n  <<: *b\nlist:\n  <<: [*b, {z: 4}]\n"
    root, found = compose(Source(yaml, "f"))
    assert found == []
    assert root is not None

    def number(*path: str) -> object:
        node = find(root, path) if root else None
        assert isinstance(node, Scalar)
        return scalar_value(node)

    assert [number("mine", "x"), number("mine", "y"), number("list", "z")] == [1, 3, 4]
    assert [f.code for f in findings("a:\n  <<: 5\n")] == ["SPEC103"]


def test_an_unknown_alias_and_one_of_itself_are_findings() -> None:
    assert [f.code for f in findings("a: *nope\n")] == ["SPEC104"]
    assert [f.code for f in findings("a: &a [1, *a]\n")] == ["SPEC104"]


def test_an_alias_bomb_ends_in_a_finding() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 30)]
    (finding,) = findings("\n".join(lines))
    assert finding.code == "SPEC109"
    merges = ["a0: &a0 {x: 1}"]
    merges += [f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 9)}]}}" for i in range(1, 30)]
    assert [f.code for f in findings("\n".join(merges))] == ["SPEC109"]


def test_bottomless_nesting_and_giant_files_end_in_a_finding() -> None:
    for yaml in ("[" * 100_000, "a: {" * 5_000, "- " * 5_000, "a: " + "x" * 2_000_000):
        assert {f.code for f in findings(yaml)} <= {"SPEC109", "SPEC100"}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        ("-5", -5),
        ("0x1F", 31),
        ("0o17", 15),
        ("010", 10),
        ("1e-4", 1e-4),
        ("1.", 1.0),
        (".5", 0.5),
        ("-.inf", float("-inf")),
        ("true", True),
        ("False", False),
        ("~", None),
        ("", None),
        ("yes", "yes"),
        ("no", "no"),
        ("y", "y"),
        ("1_000", "1_000"),
        ("1/3", "1/3"),
        ("2026-11-01", "2026-11-01"),
        ("12:30", "12:30"),
        ("'5'", "5"),
        ("!!str 5", "5"),
        ("9" * 5_000, "9" * 5_000),
    ],
)
def test_plain_values_are_read_by_the_core_schema(text: str, value: object) -> None:
    root, found = compose(Source(f"k: {text}\n", "f"))
    assert found == []
    assert isinstance(root, MappingNode)
    node = find(root, ("k",))
    assert isinstance(node, Scalar)
    assert scalar_value(node) == value
    assert type(scalar_value(node)) is type(value)


@given(st.text(alphabet="ab:& !*|>[]{}'\"\\#-?,%@\n\t<=.1", max_size=60))
def test_any_text_is_read_or_is_a_finding(text: str) -> None:
    found = findings(text)
    assert bool(render(found, "text", {"f": text})) == bool(found)
    assert all(f.span is not None for f in found)
