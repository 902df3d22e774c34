import csv
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import get_type_hints

import pytest

from tests.cli.running import Run, runner
from tests.driver.specs import spec
from tiloilc import automaton
from tiloilc.cli.logic import translate as cli_translate
from tiloilc.diag import RULES
from tiloilc.spec import json_schema
from tiloilc.sweep import sweep_schema


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


CHAIN = "G F (a & X F (b & X F c)) & G !z"


# lint


def test_lint_of_a_good_file_prints_nothing_and_exits_with_0(run: Run, tmp_path: Path) -> None:
    assert run("lint", spec(tmp_path)) == (0, "", "no findings\n")
    assert run("lint", spec(tmp_path), "--quiet") == (0, "", "")


def test_lint_prints_findings_of_all_files_and_exits_with_1(run: Run, tmp_path: Path) -> None:
    one = spec(tmp_path, ("G !y", "G !q"), name="one.yaml")
    two = spec(tmp_path, ("norm(pos)", "norm(posi)"), name="two.yaml")
    status, out, err = run("lint", two, one, "--format", "concise")
    assert status == 1
    files = [line.split(":")[0].rpartition("/")[2] for line in out.splitlines()]
    assert files == ["one.yaml", "two.yaml"]
    assert err == ""


def test_lint_as_json_follows_the_contract(run: Run, tmp_path: Path) -> None:
    status, out, _ = run("lint", spec(tmp_path, ("G !y", "G !q")), "--format", "json")
    (finding,) = json.loads(out)["diagnostics"]
    assert status == 1
    assert finding["code"] == "LTL203"
    assert (finding["line"], finding["column"], finding["end_column"]) == (9, 22, 23)


def test_lint_denies_warnings_if_told_to(run: Run, tmp_path: Path) -> None:
    path = spec(tmp_path, (" & G !y", ""))
    assert run("lint", path)[0] == 0
    assert run("lint", path, "--deny", "warnings")[0] == 1


def test_lint_of_an_unknown_format_is_a_usage_error(run: Run, tmp_path: Path) -> None:
    assert run("lint", spec(tmp_path), "--format", "xml")[0] == 2


# compile, viz, explain


def test_compile_prints_the_folder(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = run("compile", spec(tmp_path))
    assert (status, out) == (0, "build/task\n")
    assert "2 live states" in err
    assert (tmp_path / "build/task/plan.json").is_file()
    assert run("compile", tmp_path / "task.yaml", "-q", "-o", "there") == (0, "there\n", "")


def test_compile_of_a_faulty_file_writes_nothing(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = run("compile", spec(tmp_path, ("G !y", "G !q")))
    assert (status, out) == (1, "")
    assert "error[LTL203]" in err
    assert not (tmp_path / "build").exists()


@pytest.mark.parametrize(
    ("name", "begins"),
    [
        ("x.svg", b"<?xml"),
        ("x.PNG", b"\x89PNG"),
        ("x.html", b"<!DOCTYPE html>"),
        ("x.dot", b"digraph"),
        ("x.gv", b"digraph"),
        ("x.mmd", b"---\ntitle"),
    ],
)
def test_viz_writes_what_the_suffix_says(
    run: Run, tmp_path: Path, name: str, begins: bytes
) -> None:
    status, out, _ = run("viz", spec(tmp_path), "-o", tmp_path / name)
    assert (status, out) == (0, "")
    data = (tmp_path / name).read_bytes()
    assert data.startswith(begins)
    assert len(data) > 100


@pytest.mark.parametrize("name", ["flatworld_cycle", "flatworld_stabilization"])
def test_the_pictures_in_the_documents_are_those_of_viz(
    run: Run, root: Path, tmp_path: Path, name: str
) -> None:
    assert run("viz", root / "specs" / f"{name}.yaml", "-o", tmp_path / "x.svg")[0] == 0
    shown = (root / "docs" / "automata" / f"{name}.svg").read_bytes()
    assert (tmp_path / "x.svg").read_bytes() == shown


def test_viz_prints_dot_and_takes_build_folders(run: Run, tmp_path: Path) -> None:
    run("compile", spec(tmp_path), "-o", tmp_path / "out")
    from_plan = run("viz", tmp_path / "out")
    assert from_plan[0] == 0
    assert from_plan[1].startswith("digraph")
    assert from_plan[1] == run("viz", tmp_path / "task.yaml")[1]


def test_viz_of_an_unknown_suffix_is_a_usage_error(run: Run, tmp_path: Path) -> None:
    for name, told in (("x.bmp", "`.bmp`"), ("picture", "`picture`, which has no suffix,")):
        status, out, err = run("viz", spec(tmp_path), "-o", tmp_path / name)
        assert (status, out) == (2, "")
        problem = f"{told} is no format of pictures"
        assert err.startswith(f"error[AUT310]: cannot draw the automaton: {problem}\n")
        assert "use one of .svg, .png, .html" in err
        assert not (tmp_path / name).exists()


def test_viz_draws_formulas_and_automata_from_files(run: Run, tmp_path: Path) -> None:
    status, dot, _ = run("viz", "G F a & G !z")
    assert status == 0
    (tmp_path / "own.hoa").write_text(run("translate", "G F a & G !z")[1], encoding="utf-8")
    status, own, _ = run("viz", tmp_path / "own.hoa")
    assert status == 0
    assert own.count("peripheries=2") == dot.count("peripheries=2") == 1
    assert run("viz", tmp_path / "none.hoa")[0] == 2
    assert run("viz", "G F (a & ")[0] == 1


def test_viz_of_what_is_too_large_to_be_seen_is_a_finding(run: Run, tmp_path: Path) -> None:
    text = " & ".join(f"G F a{i}" for i in range(24))
    status, out, err = run("viz", text, "-o", tmp_path / "x.svg")
    assert (status, out) == (1, "")
    assert "error[AUT310]: cannot draw the automaton: it has 25 states and" in err
    assert run("viz", text, "-o", tmp_path / "x.html")[0] == 0


def test_explain_speaks_of_tasks_and_of_codes(run: Run, tmp_path: Path) -> None:
    status, out, _ = run("explain", spec(tmp_path))
    assert status == 0
    assert "stage 0 of 1: state 0, start" in out
    for code in RULES:
        status, out, _ = run("explain", code.lower())
        assert status == 0
        assert out.startswith(f"{RULES[code].severity}[{code}]")


def test_explain_tells_the_optimum_of_a_task(run: Run, root: Path) -> None:
    for task, said in {
        "grid_circular_hard": "  3 accepting visits in 144 steps: dynamic programming on all 441",
        "flatworld_cycle": "  at least 4 accepting visits in 50 steps: dynamic programming on a",
        "carlo": "  at least 11 accepting visits in 500 steps: a car at full throttle",
    }.items():
        status, out, _ = run("explain", root / "specs" / f"{task}.yaml")
        assert status == 0
        assert f"\n\nOptimum\n{said}" in out


def test_a_plan_is_explained_where_its_environment_is_not_installed(
    run: Run, tmp_path: Path
) -> None:
    assert run("compile", spec(tmp_path), "-o", tmp_path / "build")[0] == 0
    file = tmp_path / "build" / "plan.json"
    text = file.read_text("utf-8")
    assert "tiloilc/FlatWorld-v0" in text
    file.write_text(text.replace("tiloilc/FlatWorld-v0", "tiloilc/Gone-v0"), "utf-8")
    status, out, _ = run("explain", file)
    assert status == 0
    assert "Stages" in out
    assert "Optimum" not in out


def test_explain_speaks_of_formulas(run: Run) -> None:
    status, out, _ = run("explain", "G F (a & X F b) & G !z")
    assert status == 0
    for text in (
        "with all brackets: (G F (a & (X F b))) & (G !z)",
        "class: recurrence",
        "the agent has seen a and must now reach b; touching z loses for ever",
        "left to do: F b & G F (a & X F b) & G !z",
        "rejected: for ever {}",
    ):
        assert text in out
    status, out, _ = run("explain", "F a & G !a")
    assert status == 0
    assert "nothing is accepted" in out
    assert "accepted: none" in out
    assert "a, b, c" in run("explain", "F a & G !c", "--propositions", "a,b,c")[1]
    status, out, err = run("explain", "F a &")
    assert (status, out) == (1, "")
    assert "LTL201" in err


@pytest.mark.parametrize(
    ("names", "said"),
    [("a,a", "`a` is given twice"), ("b,,a", "a name is empty"), ("a, ", "a name is empty")],
)
def test_declared_propositions_have_names_of_their_own(names: str, said: str, run: Run) -> None:
    status, out, err = run("translate", "F a", "--propositions", names)
    assert (status, out) == (2, "")
    assert err == f"error: --propositions {names}: {said}\n"


@pytest.mark.parametrize("verb", ["explain", "viz", "step"])
def test_what_looks_like_a_path_is_a_missing_file_and_no_formula(run: Run, verb: str) -> None:
    assert run(verb, "build/nothing")[::2] == (2, "error: there is no file `build/nothing`\n")


def test_explain_guesses_at_unknown_codes(run: Run) -> None:
    status, out, err = run("explain", "LTL230")
    assert (status, out) == (2, "")
    assert "did you mean" in err
    assert run("explain", "nothing.yaml")[0] == 2


# translate, check


def test_translate_writes_hoa_that_goes_through_the_goals_in_order(run: Run) -> None:
    status, out, err = run("translate", CHAIN)
    assert (status, err) == (0, "")
    assert out.startswith("HOA: v1\n")
    assert "States: 4\n" in out
    steps = re.findall(r"^State: (\d).*?^\[[^!]*?(\d)&!3\] (\d)$", out, re.S | re.M)
    assert steps == [("0", "0", "1"), ("1", "1", "2"), ("2", "2", "3"), ("3", "0", "1")]


def test_translate_adds_the_sink_when_asked(run: Run) -> None:
    assert "States: 5\n" in run("translate", CHAIN, "--complete")[1]


def test_translate_marks_edges_when_asked(run: Run) -> None:
    assert "States: 3\n" in run("translate", CHAIN, "--acceptance", "edge")[1]


@pytest.mark.parametrize("choice", ["Acceptance", "Construction", "Order"])
def test_translate_offers_the_choices_of_the_translator(choice: str) -> None:
    hints = get_type_hints(automaton.translate)
    assert getattr(cli_translate, choice) == hints[choice.lower()]


def test_translate_passes_its_options_on(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[dict[str, object]] = []

    def watched(*formula: object, **options: object) -> automaton.Ldba:
        asked.append(options)
        return translator(*formula, **options)

    translator: Callable[..., automaton.Ldba] = automaton.translate
    monkeypatch.setattr(automaton, "translate", watched)
    options = ["--acceptance", "edge", "--construction", "symmetric", "--order", "free"]
    limits = ["--max-states", "77", "--timeout", "5.5"]
    assert run("translate", "F G a", *options, *limits)[0] == 0
    assert asked == [
        {
            "acceptance": "edge",
            "construction": "symmetric",
            "order": "free",
            "max_states": 77,
            "timeout": 5.5,
        }
    ]
    assert run("translate", "F G a", "--construction", "other")[0] == 2


def test_translate_writes_json_and_dot(run: Run) -> None:
    data = json.loads(run("translate", "F G a", "--format", "json")[1])
    assert data["jumps"] == [[0, 1]]
    assert run("translate", "F G a", "--format", "dot")[1].startswith("digraph")


def test_translate_of_a_file_makes_a_table(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "formulas.txt"
    file.write_text("# some\nF G a\n\nF a & G !z\n", encoding="utf-8")
    status, out, _ = run("translate", "--file", file, "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(out)))
    assert status == 0
    assert list(rows[0]) == [
        "formula",
        "states",
        "edges",
        "accepting",
        "deterministic",
        "jumps",
        "ms",
    ]
    assert [row["formula"] for row in rows] == ["F G a", "F a & G !z"]
    assert [row["states"] for row in rows] == ["2", "2"]
    assert [row["deterministic"] for row in rows] == ["false", "true"]


def test_translate_beyond_its_limits_is_a_finding_and_an_empty_row(
    run: Run, tmp_path: Path
) -> None:
    status, out, err = run("translate", CHAIN, "--max-states", "2")
    assert (status, out) == (1, "")
    assert "error[AUT305]" in err
    file = tmp_path / "formulas.txt"
    file.write_text(f"{CHAIN}\nF a\n", encoding="utf-8")
    status, out, _ = run("translate", "--file", file, "--format", "csv", "--max-states", "2")
    assert status == 1
    assert [line.count(",") for line in out.splitlines()] == [6, 6, 6]


def test_a_formula_with_a_fault_is_shown_with_a_caret(run: Run) -> None:
    status, out, err = run("translate", "G F (a & ")
    assert (status, out) == (1, "")
    assert "error[LTL201]" in err
    assert "^" in err


def test_translate_without_a_formula_is_a_usage_error(run: Run) -> None:
    assert run("translate")[0] == 2


@pytest.mark.parametrize(
    ("formulas", "status", "said"),
    [
        (
            ("G F a",),
            0,
            ["satisfiable: yes, by for ever {a}", "valid: no, by", "class: recurrence"],
        ),
        (("a & !a",), 1, ["satisfiable: no"]),
        (("a | !a",), 0, ["valid: yes", "class: bounded", "never matters: a"]),
        (
            ("F a", "G F a"),
            1,
            ["the second implies the first", "by the first only: {a} then for ever {}"],
        ),
        (("G F (a & X F b)", "G F a & G F b"), 0, ["equivalent"]),
        (("F G a", "G F a"), 1, ["the first implies the second", "accepted by the second only: "]),
        (
            ("a", "b"),
            1,
            [
                "neither implies the other",
                "the first only: for ever {a}",
                "the second only: for ever {b}",
            ],
        ),
    ],
)
def test_check_says_how_formulas_relate(
    run: Run, formulas: tuple[str, ...], status: int, said: list[str]
) -> None:
    got, out, _ = run("check", *formulas)
    assert got == status
    for text in said:
        assert text in out


# schema, doctor, init


def test_schemas_of_task_files_and_of_sweep_files_are_printed(run: Run) -> None:
    for kinds, schema in (
        ((), json_schema()),
        (("task",), json_schema()),
        (("sweep",), sweep_schema()),
    ):
        status, out, err = run("schema", *kinds)
        assert (status, json.loads(out), err) == (0, schema, "")
    assert run("schema", "sweep", "--format", "markdown")[:2] == (2, "")


def test_the_table_of_settings_is_up_to_date(run: Run, root: Path) -> None:
    """Else: `tiloilc schema --format markdown > docs/settings.md`."""
    page = (root / "docs" / "settings.md").read_text(encoding="utf-8")
    assert run("schema", "--format", "markdown")[1] == page


def test_the_doctor_names_what_is_installed(run: Run) -> None:
    status, out, _ = run("doctor", "--fast")
    assert status == 0
    assert re.search(r"^ok +numpy ", out, re.M)


def test_the_doctor_says_what_to_do(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from tiloilc.cli import doctor

    monkeypatch.setitem(doctor.REQUIRED, "no-such-package", "no_such_package")
    status, out, _ = run("doctor", "--fast")
    assert status == 1
    assert re.search(r"^missing +no-such-package +-> pip install", out, re.M)


def test_a_new_task_lints_clean(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = run("init", "my-task")
    assert (status, out) == (0, "")
    assert "next: tiloilc run my-task/my-task.yaml" in err
    names = ["README.md", "my-task.yaml", "my_task_environment.py"]
    assert sorted(path.name for path in (tmp_path / "my-task").iterdir()) == names
    status, out, _ = run("lint", "my-task/my-task.yaml", "--deny", "warnings")
    assert status == 0, out
    assert run("init", "my-task")[0] == 2


@pytest.mark.parametrize("name", ["café", "_", ".hidden", "x" * 101])
def test_a_new_task_needs_a_name_that_names_folders(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    signs = "at most 100 ASCII letters, digits, `_`, `-` and `.`, the first a letter or digit"
    assert run("init", name) == (2, "", f"error: `{name}` cannot name a task: {signs}\n")
    assert not list(tmp_path.iterdir())


def test_a_new_task_can_be_a_copy(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("init", "mine", "--from", "flatworld_cycle", "-q") == (0, "", "")
    assert Path("mine/spec.schema.json").is_file(), "what the copy names, for editors"
    assert "\nname: mine\n" in (tmp_path / "mine/mine.yaml").read_text()
    (tmp_path / "labels.py").write_text("def near(seen):\n    return seen[:, 0] > 1\n")
    own = spec(tmp_path, ("norm(pos) < 0.8", '{python: "labels.py:near"}'))
    assert run("init", "copy", "--from", own)[0] == 0
    assert (tmp_path / "copy/labels.py").is_file()
    assert run("lint", "mine/mine.yaml", "copy/copy.yaml", "--deny", "warnings")[0] == 0


@pytest.mark.parametrize(
    "env", ["MountainCarContinuous-v0", "tiloilc/FlatWorld-v0", "ours:Ours-v0", "HalfCheetah-v5"]
)
def test_a_new_task_can_be_in_an_environment_that_exists(
    env: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if env.startswith("ours"):
        assert run("init", "ours", "-q")[0] == 0
        code = Path("ours/ours_environment.py").read_text()
        Path("ours.py").write_text(code)
    assert run("init", "wrapped", "--env", env, "-q") == (0, "", "")
    status, out, _ = run("lint", "wrapped/wrapped.yaml", "--deny", "warnings")
    assert status == 0, out
    how = ("--expert", "wrapped/drive.py:drive", "-n", 1, "-o", "wrapped/demos.npz", "-q")
    assert run("demos", "record", "wrapped/wrapped.yaml", *how)[0] == 0
    assert Path("wrapped/ours.py").is_file() == env.startswith("ours")


@pytest.mark.parametrize(
    ("env", "found"),
    [
        ("MountainCart-v0", "error[JOB600]: cannot make `MountainCart-v0`"),
        ("CartPole-v1", "error[JOB608]: the sac backbone cannot learn"),
    ],
)
def test_a_new_task_in_an_environment_that_cannot_be_learned_in_is_a_finding(
    env: str, found: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, err = run("init", "wrapped", "--env", env)
    assert status == 1
    assert err.startswith(found)
    assert not Path("wrapped").exists()


def test_init_takes_an_environment_or_a_task_file(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("init", "x", "--env", "Pendulum-v1", "--from", "flatworld_cycle")[0] == 2


def test_init_refuses_names_that_are_none(run: Run, tmp_path: Path) -> None:
    assert run("init", tmp_path / "a b")[0] == 2
    assert run("init", tmp_path / "x", "--from", "no_such_task")[0] == 2


def test_a_new_task_trains(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("init", "fresh", "-q")[0] == 0
    assert run("compile", "fresh/fresh.yaml", "-q")[0] == 0
    status, out, err = run("train", "build/fresh", "--steps", "300", "--seeds", "1", "-q")
    assert status == 0, err
    assert (tmp_path / out.strip() / "events.jsonl").is_file()


def test_the_job_of_a_build_trains_its_plan(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, root: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    run("init", "fresh", "-q")
    run("compile", "fresh/fresh.yaml", "-q")
    job = [sys.executable, "build/fresh/job.py", "--steps", "200", "--seeds", "1", "-q"]
    env = {**os.environ, "PYTHONPATH": str(root)}
    done = subprocess.run(job, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / done.stdout.strip() / "plan.json").is_file()


def test_pictures_pages_and_explanations_are_the_same_under_any_hash_seed(
    root: Path, tmp_path: Path
) -> None:
    task = str(root / "specs" / "flatworld_stabilization.yaml")
    outputs = set()
    for seed in ("1", "2"):
        program = (
            "import sys; from tiloilc.cli import main\n"
            "try: main(sys.argv[1:])\nexcept SystemExit as end: assert not end.code"
        )
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(root)}
        written = [tmp_path / f"x{seed}{suffix}" for suffix in (".svg", ".html", ".mmd", ".dot")]
        told = b""
        for arguments in (["explain", task], *(["viz", task, "-o", str(file)] for file in written)):
            command = [sys.executable, "-c", program, *arguments]
            told += subprocess.run(
                command, env=environment, capture_output=True, check=True, timeout=120
            ).stdout
        outputs.add(told + b"".join(file.read_bytes() for file in written))
    assert len(outputs) == 1
