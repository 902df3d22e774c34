import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.driver.specs import ENVIRONMENT, spec
from tiloilc.demos import load
from tiloilc.diag import CompileError
from tiloilc.driver import compile_spec, labeller, load_plan, read_plan, write_build
from tiloilc.plan import digest

DEMOS = ("train:", "demonstrations: {source: expert, count: 2}\ntrain:")


def build(path: Path, folder: Path) -> Path:
    write_build(compile_spec(path), folder)
    return folder


def test_the_build_folder_has_what_the_contract_says(tmp_path: Path) -> None:
    out = build(spec(tmp_path, DEMOS), tmp_path / "build" / "task")
    names = ["automaton.hoa", "automaton.svg", "demos.json", "demos.npz", "job.py", "plan.json"]
    assert sorted(path.name for path in out.iterdir()) == names
    assert (out / "automaton.hoa").read_text().startswith("HOA: v1")
    assert "<svg" in (out / "automaton.svg").read_text()
    assert len(load(out / "demos.npz")) == 2


def test_a_plan_is_read_back_with_the_folder_of_its_task_file(tmp_path: Path) -> None:
    path = spec(tmp_path, DEMOS)
    compiled = compile_spec(path)
    write_build(compiled, tmp_path / "out")
    plan = load_plan(tmp_path / "out")
    assert plan == compiled.plan == load_plan(tmp_path / "out" / "plan.json")
    assert Path(plan.root) == tmp_path
    assert json.loads((tmp_path / "out" / "plan.json").read_text())["root"] == ".."
    assert plan.fields == {"pos": (0, 2)}


def test_the_place_of_a_task_does_not_change_the_digest(tmp_path: Path) -> None:
    for place in ("one", "two/three"):
        (tmp_path / place).mkdir(parents=True)
    plans = [compile_spec(spec(tmp_path / place, DEMOS)).plan for place in ("one", "two/three")]
    assert digest(plans[0]) == digest(plans[1])


@pytest.mark.parametrize("name", ["flatworld_cycle", "flatworld_stabilization"])
def test_two_hash_seeds_give_the_same_bytes(tmp_path: Path, root: Path, name: str) -> None:
    folders = []
    for seed in ("1", "2"):
        out = tmp_path / seed / name
        env = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(root)}
        source = f"specs/{name}.yaml"
        command = [sys.executable, "-m", "tiloilc", "compile", source, "-q", "-o", str(out)]
        subprocess.run(command, check=True, cwd=root, env=env, capture_output=True, timeout=120)
        folders.append({path.name: path.read_bytes() for path in out.iterdir()})
    assert folders[0] == folders[1]


def test_compiling_a_task_with_errors_raises_all_of_them(tmp_path: Path) -> None:
    with pytest.raises(CompileError) as caught:
        compile_spec(spec(tmp_path, ("norm(pos)", "norm(posi)"), ("G F r", "G F rr")))
    assert {"SPEC111", "LTL203"} <= {d.code for d in caught.value.diagnostics}


def test_compiling_again_leaves_nothing_of_an_older_build(tmp_path: Path) -> None:
    out = build(spec(tmp_path, DEMOS), tmp_path / "out")
    build(spec(tmp_path), out)
    assert not (out / "demos.npz").exists()
    assert load_plan(out).digests.keys() == {"spec:task.yaml"}


def stale(folder: Path) -> list[str]:
    with pytest.raises(CompileError) as caught:
        load_plan(folder)
    assert {d.code for d in caught.value.diagnostics} == {"PLAN401"}
    return [d.message for d in caught.value.diagnostics]


def test_a_changed_task_file_is_named(tmp_path: Path) -> None:
    path = spec(tmp_path)
    out = build(path, tmp_path / "out")
    path.write_text(path.read_text() + "# changed\n")
    assert stale(out) == ["`task.yaml` changed after the plan was compiled"]
    assert read_plan(out).name == "task"


def test_changed_demonstrations_and_predicates_are_named(tmp_path: Path) -> None:
    labels = tmp_path / "labels.py"
    labels.write_text("def near(seen):\n    return (seen**2).sum(-1) < 0.64\n", encoding="utf-8")
    path = spec(tmp_path, DEMOS, ("norm(pos) < 0.8", '{python: "labels.py:near"}'))
    out = build(path, tmp_path / "out")
    plan = load_plan(out)
    assert set(plan.digests) == {"demos.npz", "python:labels.py", "spec:task.yaml"}
    labels.write_text(labels.read_text() + "\n")
    (out / "demos.npz").unlink()
    assert [message.split("`")[1] for message in stale(out)] == ["demos.npz", "labels.py"]


def test_a_missing_input_is_said_to_be_missing_and_where(tmp_path: Path) -> None:
    labels = tmp_path / "labels.py"
    labels.write_text("def near(seen):\n    return (seen**2).sum(-1) < 0.64\n", encoding="utf-8")
    out = build(spec(tmp_path, ("norm(pos) < 0.8", '{python: "labels.py:near"}')), tmp_path / "out")
    labels.rename(tmp_path / "elsewhere.py")
    with pytest.raises(CompileError) as caught:
        load_plan(out)
    (finding,) = caught.value.diagnostics
    assert finding.message == "`labels.py` was moved or deleted after the plan was compiled"
    assert finding.help.endswith("/labels.py")


def test_a_plan_outlives_its_task_file(tmp_path: Path) -> None:
    path = spec(tmp_path)
    out = build(path, tmp_path / "out")
    path.unlink()
    assert load_plan(out).name == "task"


def test_an_own_environment_is_part_of_the_plan(tmp_path: Path) -> None:
    source = tmp_path / "own_room.py"
    source.write_text(ENVIRONMENT.replace("Own-v0", "OwnRoom-v0"), encoding="utf-8")
    path = spec(tmp_path, ("tiloilc/FlatWorld-v0", "own_room:OwnRoom-v0"), ("(pos", "(place"))
    out = build(path, tmp_path / "out")
    plan = load_plan(out)
    assert plan.fields == {"place": (0, 2), "speed": (2, 3), "second": (1, 3)}
    assert "environment:own_room.py" in plan.digests


def test_a_damaged_plan_is_refused(tmp_path: Path) -> None:
    out = build(spec(tmp_path), tmp_path / "out")
    text = (out / "plan.json").read_text()
    for damage in (text[: len(text) // 2], text.replace('"index"', '"indices"'), "\0"):
        (out / "plan.json").write_text(damage)
        with pytest.raises(CompileError, match="PLAN407"):
            load_plan(out)
    (out / "plan.json").write_bytes(b"\xff")
    with pytest.raises(CompileError, match="PLAN407"):
        load_plan(out)
    with pytest.raises(CompileError, match="PLAN407"):
        load_plan(tmp_path / "nowhere")


def test_the_labeller_of_a_plan_reads_its_predicates(tmp_path: Path) -> None:
    (tmp_path / "labels.py").write_text("def near(seen):\n    return seen[:, 0] > 1\n")
    path = spec(tmp_path, ("norm(pos) < 0.8", '{python: "labels.py:near"}'))
    out = build(path, tmp_path / "out")
    letters = labeller(load_plan(out))(np.array([[0.45, -0.75], [2.0, 0.0]], dtype=np.float32))
    assert letters.tolist() == [0b001, 0b100]
