from pathlib import Path

import pytest

from tests.driver.specs import ENVIRONMENT, spec
from tiloilc.diag import Diagnostic, Severity
from tiloilc.driver import lint


def codes(found: list[Diagnostic]) -> list[str]:
    return [d.code for d in found]


def excerpt(path: Path, finding: Diagnostic) -> str:
    """The characters that a finding on one line points at."""
    assert finding.span is not None
    line = path.read_text(encoding="utf-8").split("\n")[finding.span.line - 1]
    return line[finding.span.column - 1 : finding.span.end_column - 1]


def test_a_good_task_file_has_no_findings(tmp_path: Path) -> None:
    assert lint(spec(tmp_path)) == []


def test_every_bundled_task_file_is_without_errors_and_warnings(root: Path) -> None:
    specs = sorted((root / "specs").glob("*.yaml"))
    assert len(specs) >= 12
    found = {path.name: lint(path) for path in specs}
    assert not {n: f for n, f in found.items() if any(d.severity is not Severity.NOTE for d in f)}


FORMULA = '"G F r & G !y & G !b"'


@pytest.mark.parametrize(
    ("old", "new", "code", "at"),
    [
        (FORMULA, '"G F r & G !yy & G !b"', "LTL203", "yy"),
        (FORMULA, '"G F r & G & G !b"', "LTL201", None),
        (FORMULA, '"G F r & G !b"', "LTL204", "y"),
        (FORMULA, '"F r & G !r & F (y & b)"', "LTL210", '"F r & G !r & F (y & b)"'),
        (FORMULA, '"F r | G !r | y | b"', "LTL211", '"F r | G !r | y | b"'),
        (FORMULA, '"G F r & F (r | y) & G !b"', "LTL212", "r | y"),
        (FORMULA, '"G F (r & X F y) & G !b"', "LTL215", "r & X F y"),
        (FORMULA, '"F G y & G !b & F r"', "AUT301", '"F G y & G !b & F r"'),
        (FORMULA, '"F r & F y & G !b"', "PLAN405", '"F r & F y & G !b"'),
        ("steps: 1_000", "steps: 1_000\n  beta: 1/2", "PLAN404", "1/2"),
        ("steps: 1_000", "steps: 1_000\n  backbone: tabular", "JOB604", "tabular"),
        ("FlatWorld-v0", "FlatWrld-v0", "JOB600", "tiloilc/FlatWrld-v0"),
        ("  horizon: 50", "  horizon: 50\n  kwargs: {dt: 1, x: 2}", "JOB600", "kwargs"),
        ("norm(pos)", "norm(posi)", "SPEC111", "posi"),
        ("norm(pos)", "pos", "SPEC112", None),
        ("propositions:", "observation: {pos: [0, 9]}\npropositions:", "SPEC120", None),
        ("train:", "demonstrations: {file: none.npz}\ntrain:", "DEMO500", None),
        ("name: task", "nam: task", "SPEC101", "nam"),
    ],
)
def test_a_fault_is_found_and_placed(
    tmp_path: Path, old: str, new: str, code: str, at: str | None
) -> None:
    path = spec(tmp_path, (old, new))
    found = [d for d in lint(path) if d.code == code]
    assert found, codes(lint(path))
    if at is not None:
        assert excerpt(path, found[0]).strip() == at


def test_independent_faults_are_found_in_one_run_sorted_by_place(tmp_path: Path) -> None:
    path = spec(
        tmp_path,
        ("FlatWorld-v0", "FlatWrld-v0"),
        ("norm(pos) < 0.8", "norm(pos < 0.8"),
        ('"G F r', '"G F q'),
        ("steps: 1_000", "steps: 1_000\n  beta: 0.7\n  sead: 3"),
    )
    found = lint(path)
    assert {"JOB600", "SPEC110", "LTL203", "SPEC101"} <= set(codes(found))
    assert found == sorted(found, key=Diagnostic.sort_key)


def test_a_misspelt_environment_is_guessed(tmp_path: Path) -> None:
    (finding,) = lint(spec(tmp_path, ("FlatWorld-v0", "FlatWrld-v0")))
    assert "tiloilc/FlatWorld-v0" in finding.help


def test_unknown_fields_are_not_blamed_when_the_environment_is_at_fault(tmp_path: Path) -> None:
    assert codes(lint(spec(tmp_path, ("FlatWorld-v0", "FlatWrld-v0")))) == ["JOB600"]


def test_a_module_that_cannot_be_imported_says_so(tmp_path: Path) -> None:
    (finding,) = lint(spec(tmp_path, ("tiloilc/FlatWorld-v0", "no_such_module:X-v0")))
    assert finding.code == "JOB600"
    assert "import no_such_module" in finding.message


def test_an_environment_beside_the_task_file_publishes_fields_and_keys(tmp_path: Path) -> None:
    (tmp_path / "own_place.py").write_text(ENVIRONMENT, encoding="utf-8")
    path = spec(
        tmp_path,
        ("tiloilc/FlatWorld-v0", "own_place:Own-v0"),
        ("dist(pos, [0.45, -0.75]) < 0.3", "norm(place) < 0.3 and speed > 0"),
        ("dist(pos, [-0.85, 0.15]) < 0.3", "second[0] < 0"),
        ("norm(pos) < 0.8", "late < 1"),
        ("propositions:", "observation: {late: 2}\npropositions:"),
    )
    assert codes(lint(path)) == ["JOB601"]


def test_a_formula_bomb_ends_in_a_diagnostic(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tiloilc.driver import formula

    real = formula.translate
    monkeypatch.setattr(formula, "translate", lambda f, p, **_: real(f, p, max_states=2))
    found = lint(spec(tmp_path, (FORMULA, '"G F r & G F y & F b"')))
    assert "AUT305" in codes(found)
    assert all(d.span is not None for d in found)


def test_an_automaton_of_ones_own_is_refused_for_now(tmp_path: Path) -> None:
    found = lint(spec(tmp_path, (f"formula: {FORMULA}", "automaton: mine.hoa")))
    assert codes(found) == ["AUT302"]


def test_no_names_are_unknown_where_no_propositions_could_be_read(tmp_path: Path) -> None:
    path = tmp_path / "task.yaml"
    path.write_text("name: x\npropositions: []\nformula: F a\n", encoding="utf-8")
    assert not {"LTL203", "LTL204"} & set(codes(lint(path)))


def test_a_missing_file_is_a_finding(tmp_path: Path) -> None:
    assert codes(lint(tmp_path / "none.yaml")) == ["SPEC105"]


def test_demonstrations_are_replayed(tmp_path: Path) -> None:
    change = ("train:", "demonstrations: {source: expert, count: 2}\ntrain:")
    found = lint(spec(tmp_path, change, ("[0.45, -0.75]", "[1.9, 1.9]")))
    assert "DEMO501" in codes(found)


def test_python_predicates_are_found_beside_the_task_file(tmp_path: Path) -> None:
    (tmp_path / "labels.py").write_text(
        "def near(seen):\n    return (seen**2).sum(-1) < 0.64\n", encoding="utf-8"
    )
    good = spec(tmp_path, ("norm(pos) < 0.8", '{python: "labels.py:near"}'))
    assert lint(good) == []
    bad = spec(tmp_path, ("norm(pos) < 0.8", '{python: "labels.py:neat"}'))
    (finding,) = lint(bad)
    assert finding.code == "SPEC117"
    assert excerpt(bad, finding) == "labels.py:neat"
