"""Task files that name an automaton instead of a formula, from lint to the run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.driver.specs import spec
from tiloilc.automaton import accepts, to_hoa, translate
from tiloilc.cli import main
from tiloilc.demos import load
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.driver import compile_spec, lint, load_plan, read_plan, write_build
from tiloilc.ltl import Lasso, parse
from tiloilc.plan import digest
from tiloilc.plan.explain import explain

FORMULA = "G F r & G !y & G !b"
NAMED = (f'formula: "{FORMULA}"', "automaton: mine.hoa")
DEMOS = ("train:", "demonstrations: {source: expert, count: 2}\ntrain:")


def task(folder: Path, *changes: tuple[str, str], formula: str = FORMULA, hoa: str = "") -> Path:
    """A task file and beside it `mine.hoa`: that of `formula`, unless `hoa` is its text."""
    parsed = parse(formula)
    text = hoa or to_hoa(translate(parsed.formula, parsed.propositions))
    (folder / "mine.hoa").write_text(text, encoding="utf-8")
    return spec(folder, NAMED, *changes)


def codes(found: list[Diagnostic]) -> list[str]:
    return [diagnostic.code for diagnostic in found]


def test_a_task_with_an_automaton_has_no_findings(tmp_path: Path) -> None:
    assert codes(lint(task(tmp_path))) == []


def test_its_propositions_are_those_declared_in_the_declared_order(tmp_path: Path) -> None:
    path = task(tmp_path, formula="G !b & G F r & G !y")
    plan = compile_spec(path).plan
    assert plan.ldba.propositions == ("r", "y", "b")
    for letter, expected in ((0b001, True), (0b000, False), (0b011, False), (0b101, False)):
        assert accepts(plan.ldba, Lasso((), (letter,))) == expected


def test_the_plan_is_that_of_the_formula_but_for_where_it_is_from(tmp_path: Path) -> None:
    imported = compile_spec(task(tmp_path, DEMOS))
    written = compile_spec(spec(tmp_path, DEMOS, name="formula.yaml"))
    assert imported.plan.ldba == written.plan.ldba
    assert imported.plan.stages == written.plan.stages
    assert (imported.plan.formula, imported.plan.goal) == ("", "mine.hoa")
    assert (written.plan.formula, written.plan.goal) == (FORMULA, FORMULA)
    assert "automaton:mine.hoa" in imported.plan.digests
    assert [d.steps for d in imported.demos.episodes] == [d.steps for d in written.demos.episodes]


@pytest.mark.parametrize(
    ("change", "code", "file", "line"),
    [
        (("AP: 3", "AP: 4"), "AUT302", "mine.hoa", 5),
        (("1 Inf(0)", "1 Fin(0)"), "AUT303", "mine.hoa", 7),
        (("Start: 0", "Start: 0&1"), "AUT306", "mine.hoa", 4),
        (('"r"', '"R"'), "AUT307", "mine.hoa", 5),
        (("--END--", "--ABORT--"), "AUT302", "mine.hoa", None),
    ],
)
def test_a_fault_of_the_file_is_placed_in_the_file(
    tmp_path: Path, change: tuple[str, str], code: str, file: str, line: int | None
) -> None:
    path = task(tmp_path)
    text = (tmp_path / "mine.hoa").read_text(encoding="utf-8").replace("acc-name: Buchi\n", "\n")
    assert change[0] in text
    (tmp_path / "mine.hoa").write_text(text.replace(*change), encoding="utf-8")
    (found,) = lint(path)
    assert found.code == code
    assert found.span is not None
    assert found.span.file == (tmp_path / file).as_posix()
    assert line in (None, found.span.line)


def test_a_missing_file_is_placed_in_the_task_file(tmp_path: Path) -> None:
    (found,) = lint(spec(tmp_path, NAMED))
    assert (found.code, found.span and found.span.line) == ("SPEC105", 9)
    assert "no such file or directory" in found.message
    (tmp_path / "mine.hoa").write_bytes(b"HOA: v1 \xff")
    assert "not UTF-8 text" in lint(spec(tmp_path, NAMED))[0].message
    assert codes(lint(spec(tmp_path, (NAMED[0], 'automaton: ""')))) == ["SPEC103"]


def test_a_formula_and_an_automaton_are_one_too_many(tmp_path: Path) -> None:
    path = spec(tmp_path, (NAMED[0], f"{NAMED[0]}\nautomaton: mine.hoa"))
    assert codes(lint(path)) == ["SPEC108"]


def test_faults_elsewhere_are_found_as_well(tmp_path: Path) -> None:
    path = task(tmp_path, ("steps: 10_000", "stepps: 10_000"), hoa="HOA: v1")
    assert set(codes(lint(path))) == {"AUT302", "SPEC101"}


def test_what_the_automaton_means_is_told(tmp_path: Path) -> None:
    path = task(tmp_path, formula="F G r & G !b")
    assert codes(lint(path)) == ["AUT308", "AUT301", "PLAN405"]
    path = task(tmp_path, formula="r & !r & y & b")
    assert "PLAN402" in codes(lint(path))
    path = task(tmp_path, formula="F (r | !r | y | b)")
    assert "AUT309" in codes(lint(path))
    path = task(tmp_path, formula="F (r & y & b)")
    assert codes(lint(path)) == ["PLAN405"]


def test_an_automaton_too_large_to_ask_is_not_said_to_accept_everything(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tiloilc.driver import imported

    monkeypatch.setattr(imported, "UNIVERSAL_STATES", 1)
    assert codes(lint(task(tmp_path))) == []


def test_a_changed_automaton_makes_the_plan_stale_and_a_lost_one_does_not(tmp_path: Path) -> None:
    write_build(compile_spec(task(tmp_path)), tmp_path / "out")
    file = tmp_path / "mine.hoa"
    before = file.read_text(encoding="utf-8")
    file.write_text(before + "\n", encoding="utf-8")
    with pytest.raises(CompileError) as caught:
        load_plan(tmp_path / "out")
    (found,) = caught.value.diagnostics
    assert (found.code, found.message.split()[0]) == ("PLAN401", "`mine.hoa`")
    assert load_plan(tmp_path / "out", of_run=True).goal == "mine.hoa"
    file.unlink()
    assert load_plan(tmp_path / "out").goal == "mine.hoa"


def test_a_plan_is_read_back_and_explained(tmp_path: Path) -> None:
    compiled = compile_spec(task(tmp_path))
    write_build(compiled, tmp_path / "out")
    plan = read_plan(tmp_path / "out")
    assert plan == compiled.plan
    assert digest(plan) == digest(compiled.plan)
    text = explain(plan)
    assert "from the file mine.hoa" in text
    assert "accepted: for ever {r}" in text
    assert json.loads((tmp_path / "out" / "plan.json").read_text())["formula"] == ""


def test_two_hash_seeds_give_the_same_bytes(tmp_path: Path, root: Path) -> None:
    path = task(tmp_path, formula="(F G r | F (r & X F G y)) & G !b")
    built = []
    for seed in ("1", "2"):
        out = tmp_path / seed
        env = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(root)}
        command = [sys.executable, "-m", "tiloilc", "compile", str(path), "-q", "-o", str(out)]
        subprocess.run(command, check=True, cwd=root, env=env, capture_output=True, timeout=120)
        built.append({file.name: file.read_bytes() for file in out.iterdir()})
    assert built[0] == built[1]


def test_a_copied_task_takes_its_automaton_along(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = task(tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["init", "copy", "--from", str(path)])
    assert ended.value.code == 0
    assert codes(lint(tmp_path / "copy" / "copy.yaml")) == []


def test_an_automaton_alone_is_explained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["explain", str(tmp_path / "mine.hoa")])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert "r, y, b" in said
    assert "rejected: for ever {}" in said


def test_demonstrations_are_recorded_for_an_automaton(tmp_path: Path) -> None:
    path, target = task(tmp_path), tmp_path / "demos" / "task.npz"
    with pytest.raises(SystemExit) as ended:
        main(["demos", "record", str(path), "--episodes", "2", "-o", str(target)])
    assert ended.value.code == 0
    assert len(load(target)) == 2
