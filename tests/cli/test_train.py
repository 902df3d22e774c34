"""train, eval and run from the command line: folders, settings, interruptions."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.cli.running import Run, runner
from tests.learn.kills import TASKS, Task, grid_task, left_by
from tiloilc.evaluate import read

GRID = grid_task("round", 60, 10, 30)

CHATTY = """\
import os

import gymnasium
from tiloilc.tasks.grids import GridCircularEnv


class Chatty(GridCircularEnv):
    def step(self, action):
        print("said by print")
        os.write(1, b"said by a library\\n")
        return super().step(action)


gymnasium.register("Chatty-v0", Chatty)
"""

LEAVER = """\
import sys

import gymnasium
from tiloilc.tasks.grids import GridCircularEnv


class Leaver(GridCircularEnv):
    calls = 0

    def WHERE(self, *given, **named):
        Leaver.calls += 1
        if Leaver.calls > CALLS:
            sys.exit(0)
        return super().WHERE(*given, **named)


gymnasium.register("Leaver-v0", Leaver)
"""

FLAT = """\
name: stay
environment: {id: tiloilc/FlatWorld-v0, horizon: 12}
propositions:
  y: dist(pos, [-0.85, 0.15]) < 0.3
  b: norm(pos) < 0.8
formula: "F G y & G !b"
demonstrations: {source: expert, count: 2, actions: inferred}
train:
  steps: 2_000
  seeds: 2
  learning_starts: 60
  checkpoint_every: 20
  actor_hidden: [16]
  critic_hidden: [16]
  batch_size: 16
evaluate: {episodes: 2, every: 500}
"""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.fixture(autouse=True)
def quick_cloning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)


@pytest.fixture
def build(workdir: Path, run: Run) -> Path:
    """The compiled grid task."""
    (workdir / "round.yaml").write_text(GRID, encoding="utf-8")
    assert run("compile", "round.yaml", "-q")[0] == 0
    return Path("build/round")


def settings_of(folder: Path) -> dict[str, object]:
    train = json.loads((folder / "plan.json").read_text())["train"]
    assert isinstance(train, dict)
    return train


def test_train_prints_the_run_folder_and_leaves_policies(build: Path, run: Run) -> None:
    status, out, err = run("train", build)
    assert (status, out) == (0, "runs/round/0001\n")
    assert "2 seeds" in err
    folder = Path("runs/round/0001")
    for name in ("plan.json", "demos.npz", "events.jsonl", "checkpoints/last.safetensors"):
        assert (folder / name).is_file(), name
    assert run("train", build, "-q") == (0, "runs/round/0002\n", "")


def test_settings_can_be_changed_for_one_run(build: Path, run: Run) -> None:
    changes = ("--steps", "1e2", "--seeds", 1, "--set", "beta=1/4", "--set", "segment=false")
    status, _, err = run("train", build, *changes, "--set", "critic_hidden=[8, 8]")
    assert (status, "training round: 1 seed in runs/round/0001\n" in err) == (0, True)
    found = settings_of(Path("runs/round/0001"))
    assert (found["steps"], found["seeds"], found["beta"]) == (100, 1, 0.25)
    assert (found["segment"], found["critic_hidden"]) == (False, [8, 8])
    start = json.loads(Path("runs/round/0001/events.jsonl").read_text().splitlines()[0])
    assert start["overrides"]["beta"] == 0.25
    assert start["seeds"] == [0]
    assert settings_of(build)["steps"] == 60  # the build is as it was


def test_another_preset_says_what_the_task_file_keeps(build: Path, run: Run) -> None:
    err = run("train", build, "--set", "preset=paper", "--set", "learning_starts=7")[2]
    told = next(line for line in err.splitlines() if line.startswith("preset paper, but"))
    assert "checkpoint_every 10" in told
    assert settings_of(Path("runs/round/0001"))["checkpoint_every"] == 10
    assert not any(name in told for name in ("learning_starts", "seeds", "tau"))
    assert "preset" not in run("train", build, "--set", "preset=default")[2]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--set", "batchsize=3"], ["no setting `batchsize`", "batch_size"]),
        (["--set", "batch_size=0"], ["batch_size", "greater than 0"]),
        (["--set", "batch_size=many"], ["batch_size"]),
        (["--set", "batch_size"], ["NAME=VALUE"]),
        (["--set", "preset=papper"], ["preset"]),
        (["--set", "demonstrations.count=3"], ["tiloilc run SPEC --set demonstrations.count=…"]),
        (["--set", "demonstration.count=3"], ["did you mean `demonstrations.count`?"]),
        (["--steps", "ten"], ["steps"]),
        (["--steps", "9", "--set", "steps=-5"], ["`steps` is given twice"]),
        (["--seeds", "1", "--set", "seeds=0"], ["`seeds` is given twice"]),
        (["--steps", "0"], ["steps"]),
    ],
)
def test_a_wrong_setting_is_a_usage_error(
    build: Path, run: Run, arguments: list[str], words: list[str]
) -> None:
    status, out, err = run("train", build, *arguments)
    assert (status, out) == (2, "")
    assert all(word in err for word in words), err
    assert not Path("runs").exists()


def test_a_doubtful_setting_is_doubted_on_the_command_line_too(build: Path, run: Run) -> None:
    status, _, err = run("train", build, "--seeds", 1, "--set", "sink_reward=0")
    assert status == 0
    assert "warning[JOB605]: setting `sink_reward`" in err


def test_a_folder_without_plan_is_a_usage_error(workdir: Path, run: Run) -> None:
    assert run("train", "missing")[0] == 2
    (workdir / "empty").mkdir()
    status, out, err = run("train", "empty")
    assert (status, out) == (2, "")
    assert "no plan in `empty`" in err


def test_a_plan_whose_task_file_changed_is_refused(build: Path, run: Run) -> None:
    path = Path("round.yaml")
    path.write_text(path.read_text().replace("horizon: 12", "horizon: 13"))
    status, _, err = run("train", build)
    assert status == 1
    assert "PLAN401" in err
    assert "round.yaml" in err


def test_eval_prints_the_verdict(build: Path, run: Run) -> None:
    run("train", build, "-q")
    status, out, err = run("eval", "runs/round/0001", "--episodes", 3)
    assert status == 0
    assert "best by validation, greedy" in out.splitlines()[1]
    assert "optimum" in out
    assert "eval.json" in err
    found = json.loads(Path("runs/round/0001/eval.json").read_text())
    assert found["episodes"] == 3
    assert found["wall_seconds"] > 0
    sampled = run("eval", "runs/round/0001", "--stochastic", "-q")
    assert "best by validation, sampled" in sampled[1].splitlines()[1]
    assert sampled[2] == ""


def test_eval_of_an_unfinished_run_is_a_finding(build: Path, run: Run) -> None:
    run("train", build, "-q")
    for path in Path("runs/round/0001/checkpoints").glob("[a-z]*.safetensors"):
        path.unlink()
    status, out, err = run("eval", "runs/round/0001")
    assert (status, out) == (1, "")
    assert err.startswith("error[RUN706]")
    assert "--resume" in err
    assert not Path("runs/round/0001/eval.json").exists()


def test_eval_of_a_build_folder_is_a_finding_too(build: Path, run: Run) -> None:
    status, _, err = run("eval", build)
    assert status == 1
    assert "RUN701" in err
    assert "nothing was trained" in err


def test_run_does_everything(build: Path, run: Run) -> None:
    status, out, _ = run("run", "round.yaml", "--steps", 40)
    assert status == 0
    folder = Path("runs/round/0001")
    assert out.splitlines()[-1] == f"report: {folder.as_posix()}/report.html"
    assert "accepting visits" in out
    for name in ("plan.json", "events.jsonl", "eval.json", "trajectories.npz", "report.html"):
        assert (folder / name).stat().st_size > 0, name
    kinds = [json.loads(e)["type"] for e in (folder / "events.jsonl").read_text().splitlines()]
    assert (kinds[0], kinds[-1]) == ("start", "end")


def test_a_run_takes_other_demonstrations_than_the_task_file_says(build: Path, run: Run) -> None:
    plan = (build / "plan.json").read_bytes()
    given = json.loads(plan)["demonstrations"]
    changes = ("--set", "demonstrations.count=1", "--set", "demonstrations.max_visits=1")
    record = ("--record", "mine.jsonl")
    assert run("run", "round.yaml", "--steps", 40, *changes, *record, "-q")[0] == 0
    assert (build / "plan.json").read_bytes() == plan
    folder = Path("runs/round/0001")
    made = json.loads((folder / "plan.json").read_text())["demonstrations"]
    assert made == {**given, "count": 1, "max_visits": 1}
    for recorded in read(Path("mine.jsonl")):
        named = recorded.fields["demonstrations"]
        assert isinstance(named, dict)
        assert (named["count"], named["max_visits"]) == (1, 1)
    assert run("run", "round.yaml", "--steps", 40, *changes, "--resume", "-q")[0] == 0
    assert not Path("runs/round/0002").exists()


@pytest.mark.parametrize(
    ("setting", "status", "words"),
    [
        ("demonstrations.cuont=1", 2, "did you mean `demonstrations.count`?"),
        ("demonstrations.count=few", 2, "`demonstrations.count` must be a whole number, not `few`"),
        ("demonstrations.source=null", 2, "`demonstrations.source` must be `expert`, not `None`"),
        ("demonstrations.file=none.npz", 1, "none.npz"),
    ],
)
def test_wrong_demonstrations_are_told_before_anything_is_written(
    workdir: Path, run: Run, setting: str, status: int, words: str
) -> None:
    (workdir / "round.yaml").write_text(GRID, encoding="utf-8")
    found, out, err = run("run", "round.yaml", "--set", setting)
    assert (found, out) == (status, "")
    assert words in err
    assert not Path("build").exists()


def test_demonstrations_from_two_places_at_once_are_a_usage_error(build: Path, run: Run) -> None:
    both = ("--set", "demonstrations.file=a.npz", "--set", "demonstrations.source=expert")
    status, _, err = run("run", "round.yaml", *both)
    assert status == 2
    assert "`demonstrations.file` and `demonstrations.source` exclude each other" in err


def test_a_build_folder_has_its_demonstrations_already(build: Path, run: Run) -> None:
    status, _, err = run("run", build, "--set", "demonstrations.count=1")
    assert status == 2
    assert "tiloilc run SPEC" in err


def test_resuming_goes_on_with_the_newest_run_of_the_same_plan(build: Path, run: Run) -> None:
    run("train", build, "-q")
    run("train", build, "-q", "--steps", 30)
    assert run("train", build, "-q", "--resume") == (0, "runs/round/0001\n", "")
    assert run("train", "runs/round/0002", "-q", "--resume") == (0, "runs/round/0002\n", "")
    other = "`runs/round/0002` was trained with other settings: steps 30, not 77"
    _, _, err = run("train", build, "--resume", "--steps", 30)
    assert "finished already, at step 30\n" in err
    status, _, err = run("train", build, "--resume", "--steps", 77)
    assert status == 2
    assert err == f"error: no run of this plan in `runs/round` to go on with; {other}\n"
    Path("round.yaml").write_text(GRID.replace("G F (a", "F (a"), encoding="utf-8")
    run("compile", "round.yaml", "-q")
    status, _, err = run("train", build, "--resume", "--steps", 30)
    assert status == 2
    assert "; `runs/round/0002` was trained with another task file\n" in err
    shutil.rmtree("runs")
    _, _, err = run("train", build, "--resume")
    assert err == "error: no run of this plan in `runs/round` to go on with\n"


def test_resuming_a_run_with_other_settings_is_a_finding_that_names_them(
    build: Path, run: Run
) -> None:
    run("train", build, "-q", "--steps", 1200)
    options = ("--steps", 77, "--set", "optimistic=false")
    status, _, err = run("train", "runs/round/0001", "--resume", *options)
    assert status == 1
    told = "other settings: steps 1,200, not 77; optimistic auto, not false"
    assert f"error[RUN704]: the run `runs/round/0001` was trained with {told}\n" in err
    assert "help: without these options it goes on" in err
    status, _, err = run("train", "runs/round/0001", "--resume", *options, "--set", "gamma=0.5",
                         "--seeds", 1)  # fmt: skip
    assert "; …\n" in err
    assert run("train", "runs/round/0001", "--resume", "-q")[0] == 0


def test_resuming_a_run_whose_checkpoint_is_of_another_plan_is_a_finding(
    build: Path, run: Run
) -> None:
    run("train", build, "-q")
    plan = Path("runs/round/0001/plan.json")
    plan.write_text(plan.read_text().replace('"gamma": 0.', '"gamma": 0.4'))
    status, _, err = run("train", "runs/round/0001", "--resume")
    assert status == 1
    assert "RUN704" in err
    assert "another plan" in err


def test_the_same_command_twice_gives_the_same_events(build: Path, run: Run) -> None:
    for _ in range(2):
        run("train", build, "-q")
    first, second = (Path(f"runs/round/000{n}/events.jsonl").read_bytes() for n in (1, 2))
    assert first == second


def test_a_run_that_was_never_judged_well_still_has_a_verdict(build: Path, run: Run) -> None:
    """Fewer steps than random ones: nothing is learned, and nothing breaks."""
    status, _, err = run("run", "round.yaml", "--steps", 10, "-q")
    assert (status, err) == (0, "")


# as a program


def program(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "tiloilc", *map(str, arguments)]


def environment(root: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(root)}


def wait_for(path: Path, process: subprocess.Popen[str], seconds: float = 60) -> None:
    until = time.monotonic() + seconds
    while not path.exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.02)


def policies(run: Path) -> list[bytes]:
    return [path.read_bytes() for path in sorted((run / "checkpoints").glob("[a-z]*.safetensors"))]


@pytest.mark.slow
@pytest.mark.parametrize("kill", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("text", "steps"), [(GRID, 4000), (FLAT, 600)], ids=["table", "sac"])
def test_an_interrupted_program_resumed_ends_as_if_never_interrupted(
    workdir: Path, root: Path, run: Run, kill: signal.Signals, text: str, steps: int
) -> None:
    (workdir / "task.yaml").write_text(text, encoding="utf-8")
    assert run("compile", "task.yaml", "-o", "built", "-q")[0] == 0
    name = json.loads(Path("built/plan.json").read_text())["name"]
    train = program("train", "built", "-q", "--steps", steps)
    env = environment(root)
    process = subprocess.Popen(train, text=True, stderr=subprocess.PIPE, env=env)
    first = Path("runs") / name / "0001"
    wait_for(first / "checkpoints" / "last.json", process)
    time.sleep(0.2)  # somewhere between two checkpoints
    process.send_signal(kill)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert f"tiloilc train {first.as_posix()} --resume" in err
    assert "Traceback" not in err
    assert not (first / "checkpoints" / "last.safetensors").exists()
    done = subprocess.run(program("train", first, "--resume", "-q"), env=env, timeout=120)
    assert done.returncode == 0
    whole = subprocess.run(train, env=env, timeout=120)
    assert whole.returncode == 0
    second = Path("runs") / name / "0002"
    assert (first / "events.jsonl").read_bytes() == (second / "events.jsonl").read_bytes()
    assert policies(first) == policies(second) != []


@pytest.mark.slow
@pytest.mark.parametrize("name", TASKS)
def test_a_program_killed_at_any_moment_ends_as_if_never_killed(workdir: Path, name: str) -> None:
    """At one; `python -m tests.learn.kills` does this at twenty."""
    task = Task(workdir / name, TASKS[name])
    (killed,) = task.kills(1, random.Random(5))
    assert killed.alike, killed


@pytest.mark.slow
def test_a_full_disk_ends_in_a_finding_and_an_intact_checkpoint(
    workdir: Path, root: Path, run: Run
) -> None:
    resource = pytest.importorskip("resource")
    task = Task(workdir / "table", TASKS["table"])
    folder = workdir / "runs" / "table" / "0001"
    process = subprocess.Popen(
        program("train", "table/build", "-q"),
        env=environment(root),
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for(folder / "checkpoints" / "last.json", process)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (9999, 9999))  # less than a table takes
    _, err = process.communicate(timeout=60)
    assert process.returncode == 1
    assert err.startswith("error[RUN703]: cannot write in `runs/table/0001/checkpoints`")
    assert "--resume" in err
    status, _, err = run("train", folder, "--resume")
    assert status == 0
    assert "going on at step" in err
    assert "before the last" not in err
    assert left_by(folder) == left_by(task.whole)


def test_ctrl_c_before_the_first_step_leaves_no_run_folder(
    build: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("tiloilc.evaluate.protocol.Validator", interrupted)
        assert run("train", build, "-q") == (130, "", "")
    assert not list(Path("runs").glob("*/*"))


def test_a_run_killed_before_its_first_step_can_be_resumed(build: Path, run: Run) -> None:
    run("train", build, "-q")
    first, second = (Path(f"runs/round/{n}") for n in ("0001", "0002"))
    second.mkdir()
    for name in ("plan.json", "demos.npz", "demos.json"):
        shutil.copy(first / name, second / name)
    (second / "events.jsonl").touch()
    status, out, err = run("train", build, "--resume")
    assert (status, out) == (0, "runs/round/0002\n")
    assert "beginning again: no checkpoint had been written" in err
    assert policies(first) == policies(second) != []


def test_what_an_environment_prints_is_no_result(
    workdir: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (workdir / "chatty.py").write_text(CHATTY, encoding="utf-8")
    text = GRID.replace("tiloilc/GridCircular-v0", "chatty:Chatty-v0")
    (workdir / "task.yaml").write_text(text, encoding="utf-8")
    run = runner(capfd)
    assert run("compile", "task.yaml", "-q")[1] == "build/round\n"
    status, out, err = run("train", "build/round", "-q")
    assert (status, out) == (0, "runs/round/0001\n")
    assert "said by print" in err
    assert "said by a library" in err
    for command in (
        ("lint", "task.yaml", "--format", "json"),
        ("eval", "runs/round/0001"),
        ("report", "runs/round/0001"),
        ("step", "task.yaml", "--demo", 0),
    ):
        status, out, err = run(*command)
        assert (status, out == "") == (0, False), err
        assert "said" not in out, command


def test_a_damaged_file_of_records_is_noticed_before_training(build: Path, run: Run) -> None:
    Path("records.jsonl.gz").write_bytes(b"damaged")
    status, out, err = run("run", "round.yaml", "--record", "records.jsonl.gz")
    assert (status, out) == (1, "")
    assert "RUN701" in err
    assert "records.jsonl.gz" in err
    assert not Path("runs").exists()


def test_a_place_where_no_records_can_be_is_noticed_before_training(build: Path, run: Run) -> None:
    status, out, err = run("run", "round.yaml", "--record", "round.yaml/x.jsonl.gz")
    assert (status, out) == (2, "")
    assert "round.yaml" in err
    assert not Path("runs").exists()


@pytest.mark.parametrize(("where", "calls"), [("reset", 40), ("step", 120)])
def test_an_environment_that_ends_the_program_is_a_finding(
    workdir: Path, run: Run, where: str, calls: int
) -> None:
    text = LEAVER.replace("WHERE", where).replace("CALLS", str(calls))
    (workdir / f"leaver_{where}.py").write_text(text, encoding="utf-8")
    text = GRID.replace("tiloilc/GridCircular-v0", f"leaver_{where}:Leaver-v0")
    (workdir / "task.yaml").write_text(text, encoding="utf-8")
    status, out, err = run("run", "task.yaml", "-q")
    assert (status, out) == (1, "")
    assert "error[RUN707]" in err
    assert "it ends the program" in err


def test_a_run_is_trained_by_one_process_at_a_time(build: Path, run: Run) -> None:
    fcntl = pytest.importorskip("fcntl")
    run("train", build, "-q")
    folder = Path("runs/round/0001")
    before = {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        status, out, err = run("train", folder, "--resume", "-q")
    finally:
        os.close(handle)
    assert (status, out) == (2, "")
    assert err == "error: `runs/round/0001` is being trained by another process\n"
    assert {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()} == before
    assert run("train", folder, "--resume", "-q")[0] == 0


def test_a_damaged_run_does_not_stand_in_the_way_of_another(build: Path, run: Run) -> None:
    run("train", build, "-q")
    run("train", build, "-q", "--steps", 30)
    Path("runs/round/0002/plan.json").write_text("{")
    assert run("train", build, "-q", "--resume") == (0, "runs/round/0001\n", "")


@pytest.mark.parametrize("log", [b"\xff\xfe\n", b"[]\n", b'{"type": "ev', None])
def test_eval_says_which_file_of_a_run_is_damaged(build: Path, run: Run, log: bytes | None) -> None:
    run("train", build, "-q")
    events = Path("runs/round/0001/events.jsonl")
    events.unlink() if log is None else events.write_bytes(log)
    status, _, err = run("eval", "runs/round/0001")
    assert status == 1
    assert "RUN701" in err
    assert "events.jsonl" in err
