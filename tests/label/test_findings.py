"""Wrong predicates: each code, and the caret on the right characters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tiloilc.diag import CompileError, Diagnostic, SourceText, render
from tiloilc.label import compile_predicates

FIELDS = {"pos": (0, 2), "v": (2, 5), "s": (5, 6)}


def findings(predicate: str) -> tuple[Diagnostic, ...]:
    text = SourceText.plain(predicate, "f")
    with pytest.raises(CompileError) as caught:
        compile_predicates({"p": text}, FIELDS)
    return caught.value.diagnostics


def marked(predicate: str, diagnostic: Diagnostic) -> str:
    span = diagnostic.span
    assert span is not None
    return predicate.splitlines()[span.line - 1][span.column - 1 : span.end_column - 1]


WRONG = [
    ("norm(pos) <", "SPEC110", "<", "a value is missing after `<`"),
    ("s > 0 and", "SPEC110", "and", "a value is missing after `and`"),
    ("< 3", "SPEC110", "<", "a value is missing before `<`"),
    ("s < and", "SPEC110", "and", "`and` stands where a value is expected"),
    ("s > 0)", "SPEC110", ")", "`)` closes nothing"),
    ("(s > 0", "SPEC110", "(", "`(` is never closed"),
    ("(s > 0]", "SPEC110", "]", "`(` is closed by `]`"),
    ("s = 1", "SPEC110", "=", "`=` is not part of the language"),
    ("s > 0 && s < 1", "SPEC110", "&&", "`&&` is not part of the language"),
    ("!s", "SPEC110", "!", "`!` is not part of the language"),
    ("s 3", "SPEC110", "3", "an operator is missing before `3`"),
    ("1.2.3 < s", "SPEC110", ".3", "`.3`"),
    ("s > 'x'", "SPEC110", "'", "quotes"),
    ("s > 0, s", "SPEC110", ",", "a comma has no place here"),
    ("norm(poz) < 1", "SPEC111", "poz", "unknown field `poz`"),
    ("norm < 1", "SPEC111", "norm", "unknown field `norm`"),
    ("dist(pos, [1, 2, 3]) < 1", "SPEC112", "[1, 2, 3]", "a vector of 2 and a vector of 3"),
    ("dist(pos, 0) < 1", "SPEC112", "0", "a vector of 2 and a number"),
    ("norm(pos + v) < 1", "SPEC112", "v", "do not fit together"),
    ("pos < 1", "SPEC112", "pos", "`<` needs a single number, not a vector of 2"),
    ("0 < s < pos", "SPEC112", "pos", "`<` needs a single number"),
    ("s and true", "SPEC112", "s", "`and` needs truth values, not a number"),
    ("not pos", "SPEC112", "pos", "`not` needs truth values"),
    ("(s > 0) + 1 > 0", "SPEC112", "s > 0", "`+` needs numbers, not a truth value"),
    ("true == s", "SPEC112", "true", "`==` needs numbers"),
    ("-true > 0", "SPEC112", "true", "`-` needs numbers"),
    ("norm(true) > 0", "SPEC112", "true", "`norm` needs numbers"),
    ("[pos, 1] == 1", "SPEC112", "pos", "a component needs a single number"),
    ("[] == 1", "SPEC112", "[]", "at least one component"),
    ("pos[0.5] > 0", "SPEC112", "0.5", "an index is a whole number"),
    ("pos[s] > 0", "SPEC112", "s", "an index is a whole number"),
    ("true[0] > 0", "SPEC112", "true", "an index needs numbers"),
    ("in_ball(pos, [0, 0], pos)", "SPEC112", "pos", "`in_ball` needs a number here"),
    ("in_box(pos, v, 1)", "SPEC112", "v", "`in_box` tests a vector of 2 against a vector of 3"),
    ("in_box(s, pos, 1)", "SPEC112", "pos", "`in_box` tests a number against"),
    ("norm(pos)", "SPEC113", "norm(pos)", "the predicate is a number"),
    ("pos", "SPEC113", "pos", "the predicate is a vector of 2"),
    ("pos[2] > 0", "SPEC114", "2", "there is no component 2"),
    ("pos[-3] > 0", "SPEC114", "-3", "there is no component -3"),
    ("s[1] > 0", "SPEC114", "1", "the vector has one component"),
    ("nrm(pos) < 1", "SPEC115", "nrm", "unknown function `nrm`"),
    ("pos(0) < 1", "SPEC115", "pos", "unknown function `pos`"),
    ("norm(pos, 1) < 1", "SPEC116", "norm(pos, 1)", "`norm` takes 1 argument, not 2"),
    ("atan2(1) < 1", "SPEC116", "atan2(1)", "`atan2` takes 2 arguments, not 1"),
    ("min() < 1", "SPEC116", "min()", "`min` takes at least 1 argument, not 0"),
]


@pytest.mark.parametrize(
    ("predicate", "code", "piece", "message"), WRONG, ids=[w[0] for w in WRONG]
)
def test_a_wrong_predicate_is_one_finding_at_its_place(
    predicate: str, code: str, piece: str, message: str
) -> None:
    (finding,) = findings(predicate)
    assert finding.code == code
    assert marked(predicate, finding) == piece
    assert message in finding.message


def test_an_empty_predicate_is_a_finding() -> None:
    assert [f.code for f in findings("")] == ["SPEC110"]
    assert [f.code for f in findings("  \n ")] == ["SPEC110"]


def test_independent_mistakes_are_all_found() -> None:
    text = "norm(poz) < 1 and pos[7] > nrm(v)"
    assert [f.code for f in findings(text)] == ["SPEC111", "SPEC114", "SPEC115"]
    with pytest.raises(CompileError) as caught:
        compile_predicates({"a": "x > 0", "b": "s >", "c": "pos"}, FIELDS)
    assert [d.code for d in caught.value.diagnostics] == ["SPEC111", "SPEC110", "SPEC113"]


def test_one_mistake_is_one_finding_however_it_is_used() -> None:
    assert len(findings("dist(poz + 1, [0, poz]) < norm(2 * pos) and not s > 1")) == 2
    assert len(findings("max(nrm(pos), 1)[0] + 1 < 2")) == 1


def test_a_caret_in_the_second_line_is_there() -> None:
    text = "s > 0 and\n  norm(poz) < 1"
    (finding,) = findings(text)
    assert finding.span is not None
    assert (finding.span.line, finding.span.column) == (2, 8)


def test_other_languages_get_the_word_to_write_instead() -> None:
    for text, word in (("s > 0 || s < 1", "`or`"), ("s ^ 2 > 1", "`**`"), ("¬s", "`not`")):
        assert word in findings(text)[0].help


@pytest.mark.parametrize("text", ["-" * 500 + "s > 0", "not " * 500 + "s > 0", "abs(" * 500])
def test_a_bottomless_predicate_is_a_finding_and_no_traceback(text: str) -> None:
    assert findings(text)[0].code in ("SPEC119", "SPEC110")


def test_deep_brackets_and_long_chains_are_fine() -> None:
    seen = np.zeros((2, 6), np.float32)
    seen[:, 5] = 1, -1
    for text in (
        "(" * 500 + "s > 0" + ")" * 500,
        " + ".join(["s"] * 2_000) + " > 1999",
        " or ".join(["s > 0"] * 2_000),
    ):
        assert compile_predicates({"p": text}, FIELDS)(seen).tolist() == [1, 0]


def test_a_field_outside_the_observation_is_a_finding() -> None:
    compile_predicates({"p": "s > 0"}, FIELDS, size=6)
    with pytest.raises(CompileError, match="SPEC120"):
        compile_predicates({"p": "s > 0"}, FIELDS, size=5)
    with pytest.raises(CompileError, match="the observation has 1 component;"):
        compile_predicates({"p": "s > 0"}, {"s": (0, 2)}, size=1)


@given(st.text(alphabet="spov[]()0129.,<>=+-*/% anotdrminx_\n", max_size=30))
def test_any_text_compiles_or_is_a_finding_with_a_place(text: str) -> None:
    found: tuple[Diagnostic, ...] = ()
    try:
        compile_predicates({"p": SourceText.plain(text, "f")}, FIELDS)
    except CompileError as error:
        found = error.diagnostics
    assert all(d.span is not None for d in found)
    assert bool(render(found, "text", {"f": text})) == bool(found)
