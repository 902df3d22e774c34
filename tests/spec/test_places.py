"""Every character of a YAML value knows where it stands in the file, whatever the style."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML
from ruamel.yaml.scalarstring import (
    DoubleQuotedScalarString,
    FoldedScalarString,
    LiteralScalarString,
    SingleQuotedScalarString,
)

from tiloilc.spec.compose import compose
from tiloilc.spec.nodes import MappingNode, Scalar, Source, find

STYLES = (
    str,
    DoubleQuotedScalarString,
    SingleQuotedScalarString,
    FoldedScalarString,
    LiteralScalarString,
)


def scalar(yaml: str, *path: str | int) -> Scalar:
    root, findings = compose(Source(yaml, "f"))
    assert isinstance(root, MappingNode)
    assert findings == []
    node = find(root, path)
    assert isinstance(node, Scalar)
    return node


def covered(yaml: str, node: Scalar, piece: str) -> str:
    """The file's text behind `piece` of the value, within one line."""
    start = node.text.value.index(piece)
    span = node.text.span(start, start + len(piece))
    assert span.line == span.end_line
    return yaml.split("\n")[span.line - 1][span.column - 1 : span.end_column - 1]


@pytest.mark.parametrize(
    "yaml",
    [
        "k: F (a & bad)\n",
        'k: "F (a & bad)"\n',
        "k: 'F (a & bad)'\n",
        "k: 'it''s F (a & bad)'\n",
        'k: "tab\\t \\u00e9 \\"F\\" \\x41 \\U0001F600 (a & bad)"\n',
        'k: "F\n\n   (a \\\n   & bad)"\n',
        "k: 'F\n   (a\n\n   & bad)'\n",
        "k: F\n  (a &   \n    bad)   # comment\n",
        "k: >\n  F (a &\n     deeper\n\n  bad)\n",
        "k: >-  # comment\n\n  F (a &\n  bad)\n\n",
        "k: |\n  F (a &\n    bad)\n",
        "k: |2\n    F (a &\n  bad)\n",
        "k: &anchor F (a & bad)\n",
        'k: !!str "F (a & bad)"\n',
        "k: &x !!str\n  'F (a & bad)'\n",
        "{k: F (a & bad)}\n",
        "\n\n? k\n: F (a & bad)\n",
        "k: F (a & bad)\r\nl: 1\r\n",
        "k: 日本 F (a & bad)\n",
    ],
)
def test_a_caret_inside_a_value_is_on_the_right_characters(yaml: str) -> None:
    assert covered(yaml, scalar(yaml, "k"), "bad") == "bad"


def test_an_escape_is_one_character_at_its_backslash() -> None:
    node = scalar('k: "a\\tb\\u0041c"\n', "k")
    assert node.text.value == "a\tbAc"
    assert [column for _, column in node.text.places] == [5, 6, 8, 9, 15, 16]


def test_the_end_of_a_block_is_after_its_last_word() -> None:
    node = scalar("k: |\n  F a &\n\n\nl: 1\n", "k")
    assert node.text.value == "F a &\n"
    assert node.text.places[-1] == (2, 8)


def test_the_end_of_a_quoted_value_is_its_closing_quote() -> None:
    assert scalar('k: "F a &"\n', "k").text.places[-1] == (1, 10)
    assert scalar('k: ""\n', "k").text.places == ((1, 5),)


def test_the_span_of_a_value_has_its_quotes() -> None:
    span = scalar('k:   "F a"   # c\n', "k").span
    assert (span.column, span.end_column) == (6, 11)


texts = st.text(alphabet="ab(&é日\"'\\#:!- \n", max_size=40)


@given(texts, st.sampled_from(STYLES), st.sampled_from([20, 80]))
def test_places_agree_with_the_file_for_whatever_yaml_writes(
    value: str, style: type[str], width: int
) -> None:
    """Written by ruamel, read by us: each visible character stands where its place says."""
    writer = YAML(pure=True)
    writer.width = width
    out = io.StringIO()
    try:
        writer.dump({"first": 1, "k": {"deep": style(value)}}, out)
    except Exception:
        return
    yaml = out.getvalue()
    node = scalar(yaml, "k", "deep")
    lines = yaml.split("\n")
    for character, (line, column) in zip(node.text.value, node.text.places, strict=False):
        if not character.isspace() and character not in "'\"\\é日":
            assert lines[line - 1][column - 1] == character, yaml
    assert len(node.text.places) == len(node.text.value) + 1
