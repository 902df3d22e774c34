"""What a finding looks like: the contract's example to the letter, and the hard lines."""

from __future__ import annotations

import json

import pytest

from tiloilc.diag import (
    FORMATS,
    CompileError,
    Diagnostic,
    Severity,
    SourceText,
    Span,
    exit_status,
    render,
)

FILE = "specs/fetch_align.yaml"
TEXT = "# a line\n" * 13 + 'formula: "F (a & X F (b & X F cc))"\n'
SOURCES = {FILE: TEXT}


def found(
    text: str, piece: str, *, code: str = "LTL203", label: str = "", help: str = "", file: str = "f"
) -> Diagnostic:
    start = text.index(piece)
    span = SourceText.plain(text, file).span(start, start + len(piece))
    return Diagnostic.of(code, span, label=label, help=help, name=piece)


CONTRACT = found(
    TEXT, "cc", label="not declared", help="did you mean `c`? declared: a, b, c", file=FILE
)


def carets(text: str, piece: str, label: str = "") -> str:
    """The excerpt's lines, without the gutter."""
    lines = render([found(text, piece, label=label)], "text", {"f": text}).splitlines()
    return "\n".join(line.split("| ", 1)[-1] for line in lines[3:])


def test_text_looks_as_the_contract_says() -> None:
    assert render([CONTRACT], "text", SOURCES) == (
        "error[LTL203]: unknown proposition `cc`\n"
        "  --> specs/fetch_align.yaml:14:31\n"
        "   |\n"
        '14 | formula: "F (a & X F (b & X F cc))"\n'
        "   |                               ^^ not declared\n"
        "   |\n"
        "   = help: did you mean `c`? declared: a, b, c\n"
    )


def test_concise_is_one_line_a_finding() -> None:
    assert render([CONTRACT, Diagnostic.of("LTL210")], "concise", SOURCES) == (
        "error[LTL210] no behaviour satisfies the formula\n"
        "specs/fetch_align.yaml:14:31: error[LTL203] unknown proposition `cc`\n"
    )


def test_json_has_the_keys_of_the_contract() -> None:
    document = json.loads(render([CONTRACT, Diagnostic.of("LTL210")], "json", SOURCES))
    assert document["schema_version"] == 1
    assert document["diagnostics"][0]["file"] is None
    assert document["diagnostics"][1] == {
        "code": "LTL203",
        "severity": "error",
        "message": "unknown proposition `cc`",
        "file": FILE,
        "line": 14,
        "column": 31,
        "end_line": 14,
        "end_column": 33,
        "help": "did you mean `c`? declared: a, b, c",
    }


def test_github_annotates_the_line() -> None:
    assert render([CONTRACT], "github", SOURCES) == (
        "::error file=specs/fetch_align.yaml,line=14,endLine=14,col=31,endColumn=33,title=LTL203::"
        "unknown proposition `cc`%0Ahelp: did you mean `c`? declared: a, b, c\n"
    )
    odd = Diagnostic.of("LTL203", Span("a,b:c%.yaml", 1, 1, 2, 1), name="100%\n")
    assert render([odd], "github", {}) == (
        "::error file=a%2Cb%3Ac%25.yaml,line=1,endLine=2,title=LTL203::"
        "unknown proposition `100%25\\n`\n"
    )
    assert render([Diagnostic.of("LTL215", part="x")], "github", {}).startswith("::notice title=")


def test_sarif_names_rules_results_and_places() -> None:
    document = json.loads(render([CONTRACT, Diagnostic.of("LTL210")], "sarif", SOURCES))
    (run,) = document["runs"]
    assert document["version"] == "2.1.0"
    assert [rule["id"] for rule in run["tool"]["driver"]["rules"]] == ["LTL203", "LTL210"]
    bare, placed = run["results"]
    assert "locations" not in bare
    assert (placed["ruleId"], placed["ruleIndex"], placed["level"]) == ("LTL203", 0, "error")
    location = placed["locations"][0]["physicalLocation"]
    assert location["artifactLocation"]["uri"] == FILE
    assert location["region"] == {
        "startLine": 14,
        "startColumn": 31,
        "endLine": 14,
        "endColumn": 33,
    }


def test_findings_are_sorted_by_place_whatever_their_order() -> None:
    text = "one two three\nfour\n"
    pieces = [found(text, piece) for piece in ("four", "three", "one", "two", "one")]
    for format in FORMATS:
        assert render(pieces, format, {"f": text}) == render(pieces[::-1], format, {"f": text})
    places = [line.split(":")[1:3] for line in render(pieces, "concise", {}).splitlines()]
    assert places == [["1", "1"], ["1", "5"], ["1", "9"], ["2", "1"]]


def test_at_one_place_the_graver_finding_comes_first() -> None:
    span = Span("f", 1, 1, 1, 2)
    note, error = Diagnostic.of("AUT301", span, problem="x"), Diagnostic.of("LTL210", span)
    assert render([note, error], "concise", {}).index("LTL210") == len("f:1:1: error[")


def test_carets_stand_right_after_a_tab() -> None:
    assert carets("\ta: bad", "bad") == "    a: bad\n       ^^^"


def test_carets_stand_right_after_wide_and_combining_characters() -> None:
    assert carets("日本 bad", "bad") == "日本 bad\n     ^^^"
    assert carets("e\u0301 bad", "bad") == "e\u0301 bad\n  ^^^"


def test_wide_characters_get_two_carets_each() -> None:
    assert carets("a 日本", "日本") == "a 日本\n  ^^^^"


def test_a_stretch_of_several_lines_has_carets_under_each() -> None:
    text = "formula: >\n  F (a &\n\n     b) x\n"
    assert carets(text, "(a &\n\n     b)", "here") == "  F (a &\n    ^^^^\n     b) x\n     ^^ here"


def test_the_middle_of_a_long_stretch_is_left_out() -> None:
    text = "".join(f"line{n}\n" for n in range(20))
    shown = render([found(text, text.rstrip())], "text", {"f": text})
    assert "line2\n" in shown
    assert "\n...\n" in shown
    assert "line3\n" not in shown
    assert "line19\n" in shown


def test_a_very_long_line_is_cut_around_the_caret() -> None:
    text = "x" * 5_000 + " bad " + "y" * 5_000
    line, under = carets(text, "bad").splitlines()
    assert len(line) < 200
    assert line[under.index("^") : under.rindex("^") + 1] == "bad"


def test_an_empty_stretch_at_the_end_of_a_line_is_one_caret() -> None:
    span = SourceText.plain("F a &", "f").span(5, 5)
    shown = render([Diagnostic.of("LTL210", span)], "text", {"f": "F a &"})
    assert shown.endswith("1 | F a &\n  |      ^\n")


def test_control_characters_never_reach_the_terminal() -> None:
    text = "a: \x1b[31m\u202e bad"
    diagnostic = Diagnostic.of("LTL203", SourceText.plain(text, "f").span(8), name="x\n\x1b[0m")
    for format in ("text", "concise"):
        shown = render([diagnostic], format, {"f": text})
        assert "\x1b" not in shown
        assert "\u202e" not in shown
        assert "x\\n\\x1b[0m" in shown


def test_a_carriage_return_is_no_part_of_the_line() -> None:
    assert carets("a: bad\r\nb: c\r\n", "bad") == "a: bad\n   ^^^"


def test_a_finding_without_a_place_or_source_still_says_its_help() -> None:
    bare = Diagnostic.of("LTL210", help="do this")
    assert render([bare], "text", {}).splitlines() == [
        "error[LTL210]: no behaviour satisfies the formula",
        "  = help: do this",
    ]
    assert render([CONTRACT], "text", {}).splitlines()[1:] == [
        "  --> specs/fetch_align.yaml:14:31",
        "   = help: did you mean `c`? declared: a, b, c",
    ]


def test_a_place_beyond_the_text_does_not_break_the_renderer() -> None:
    for span in (Span("f", 9, 1, 9, 2), Span("f", 1, 50, 1, 60), Span("f", 1, 2, 7, 3)):
        assert "LTL210" in render([Diagnostic.of("LTL210", span)], "text", {"f": "abc"})


def test_colour_only_adds_escape_sequences() -> None:
    import re

    coloured = render([CONTRACT], "text", SOURCES, colour=True)
    assert "\x1b[1;31merror[LTL203]" in coloured
    plain = re.sub(r"\x1b\[[0-9;]*m", "", coloured)
    assert plain == render([CONTRACT], "text", SOURCES)


def test_nothing_found_says_nothing() -> None:
    assert render([], "text", {}) == ""
    assert render([], "concise", {}) == ""
    assert json.loads(render([], "json", {}))["diagnostics"] == []


@pytest.mark.parametrize(
    ("codes", "status", "denied"),
    [([], 0, 0), (["LTL215"], 0, 0), (["LTL204"], 0, 1), (["LTL204", "LTL210"], 1, 1)],
)
def test_exit_status_is_of_errors_and_of_denied_warnings(
    codes: list[str], status: int, denied: int
) -> None:
    findings = [Diagnostic.of(code, name="a", part="GF a") for code in codes]
    assert exit_status(findings) == status
    assert exit_status(findings, deny_warnings=True) == denied


def test_a_compile_error_names_its_codes() -> None:
    assert str(CompileError(CONTRACT)) == "[LTL203] unknown proposition `cc`"
    assert CONTRACT.severity is Severity.ERROR
