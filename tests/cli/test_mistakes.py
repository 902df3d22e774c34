"""What users mistake: wrong folders, wrong settings, odd encodings. One line helps each."""

from pathlib import Path

import pytest

from tests.cli.running import Run, runner
from tests.driver.specs import spec


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("beta=", "`beta` must be a number, not ``"),
        ("beta=nan", "`beta` must be a finite number, not `nan`"),
        ("actor_hidden=8", "`actor_hidden` must be a list, not `8`"),
        ("actor_hidden=[]", "`actor_hidden` must not be empty"),
        ("actor_hidden=[0]", "`actor_hidden` must be greater than 0, not `0`"),
        ("segment=maybe", "`segment` must be true or false, not `maybe`"),
        ("preset=x", "`preset` must be `default` or `paper`, not `x`"),
        ("gamma=1", "`gamma` must be at most 0.99999, not `1`"),
        ("betta=1", "no setting `betta`; did you mean `beta`?"),
        ("beta", "--set needs NAME=VALUE"),
    ],
)
def test_a_setting_that_cannot_be_is_refused_in_words(
    run: Run, here: Path, change: str, said: str
) -> None:
    run("compile", spec(here), "-q")
    status, out, err = run("train", "build/task", "--set", change)
    assert (status, out) == (2, "")
    assert said in err
    assert len(err.splitlines()) == 1
    assert not Path("runs").exists()


def test_a_changed_setting_is_checked_as_in_a_task_file(run: Run, here: Path) -> None:
    run("compile", spec(here), "-q")
    status, _, err = run("train", "build/task", "--set", "beta=1/2")
    assert status == 1
    assert err.startswith("error[PLAN404]")
    assert not Path("runs").exists()


def test_a_task_file_is_not_a_plan(run: Run, here: Path) -> None:
    spec(here)
    status, _, err = run("train", "task.yaml")
    assert status == 2
    assert "tiloilc run task.yaml" in err


@pytest.mark.parametrize("verb", ["viz", "explain", "step"])
def test_a_folder_without_a_plan_is_said_to_have_none(run: Run, here: Path, verb: str) -> None:
    assert run(verb, ".") == (2, "", "error: no plan in `.`; compile a task file first\n")


@pytest.mark.parametrize("verb", ["viz", "step", "explain", "check"])
def test_an_empty_text_is_an_empty_formula_not_the_folder(run: Run, here: Path, verb: str) -> None:
    status, out, err = run(verb, "")
    assert (status, out) == (1, "")
    assert err.startswith("error[LTL201]: cannot read the formula: expected a formula, found not")
    assert " --> <formula>:1:1\n" in err


@pytest.mark.parametrize("verb", ["viz", "step", "explain"])
def test_a_faulty_automaton_is_a_finding(run: Run, here: Path, verb: str) -> None:
    Path("x.hoa").write_text("HOA: v1\n")
    status, out, err = run(verb, "x.hoa")
    assert (status, out) == (1, "")
    assert err.startswith("error[AUT302]")
    Path("x.hoa").write_bytes(b"HOA: v1 \xff\n")
    assert run(verb, "x.hoa") == (2, "", "error: cannot read `x.hoa`: not UTF-8 text (byte 8)\n")


@pytest.mark.parametrize("verb", ["viz", "step"])
def test_what_is_no_file_is_a_formula(run: Run, here: Path, verb: str) -> None:
    assert run(verb, "nothing.yaml")[2] == "error: there is no file `nothing.yaml`\n"
    status, out, err = run(verb, "F (a & ")
    assert (status, out) == (1, "")
    assert err.startswith("error[LTL201]")


def test_a_faulty_formula_of_a_file_does_not_hide_the_others(run: Run, here: Path) -> None:
    Path("formulas.txt").write_bytes(b"\xef\xbb\xbfF a\r\n# more\r\n\r\n  F (\r\nG b\r\n")
    status, out, err = run("translate", "--file", "formulas.txt", "--format", "csv")
    assert status == 1
    assert [line.split(",")[0] for line in out.splitlines()] == ["formula", "F a", "F (", "G b"]
    assert "formulas.txt:4:5" in err
    status, out, _ = run("translate", "--file", "formulas.txt")
    assert (status, out.count("HOA: v1")) == (1, 2)


def test_formulas_must_be_utf_8(run: Run, here: Path) -> None:
    Path("formulas.txt").write_bytes("F ü".encode("latin-1"))
    status, out, err = run("translate", "--file", "formulas.txt")
    assert (status, out) == (2, "")
    assert err == "error: cannot read `formulas.txt`: not UTF-8 text (byte 2)\n"
