"""`tiloilc demos`: recording, checking and converting."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.cli.running import Run, runner
from tiloilc.demos import bundled, load, save

SWING = """\
name: swing
environment:
  id: MountainCarContinuous-v0
  horizon: 150
observation:
  position: 0
propositions:
  left: position < -0.8
  flag: position >= 0.45
formula: "F (left & X F flag)"
demonstrations:
  file: swing.npz
train:
  steps: 4_000
"""

LAKE = SWING.replace("MountainCarContinuous-v0", "FrozenLake-v1").replace("0.45", "15")

DRIVE = """\
def drive(generator):
    swung = False

    def act(observation):
        nonlocal swung
        position, velocity = observation
        swung = swung or position < -0.8
        if not swung and position > 0.1:
            return [-1.0]
        return [1.0 if velocity > 0 else -1.0]

    return act


def brief(generator):
    steps = iter(range(7))
    return lambda observation: None if next(steps, None) is None else [1.0]


def broken(generator):
    return lambda observation: [1.0, 2.0]


def raising(generator):
    raise RuntimeError("no fuel")
"""

WEARY = """\
import gymnasium
import numpy as np


class Weary(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(-1, 1, (1,))
    action_space = gymnasium.spaces.Box(-1, 1, (1,))

    def __init__(self, how):
        self.how = how

    def reset(self, *, seed=None, options=None):
        self.steps = 0
        if self.how == "reset" and seed == 0:
            raise RuntimeError("no start")
        return np.zeros(1, np.float32), {}

    def step(self, action):
        self.steps += 1
        tired = self.steps > 5
        if self.how == "step" and tired:
            raise RuntimeError("no breath")
        seen = np.full(1, np.nan if tired else 0.0, np.float32)
        return seen if self.how != "size" or not tired else np.zeros(2), 0.0, False, False, {}


gymnasium.register("Weary-v0", entry_point=Weary)
"""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.fixture
def swing(workdir: Path) -> Path:
    """A folder with a task of somebody else's environment, and ways to drive in it."""
    (workdir / "swing.yaml").write_text(SWING, encoding="utf-8")
    (workdir / "drive.py").write_text(DRIVE, encoding="utf-8")
    return workdir


@pytest.mark.parametrize("task", ["flatworld_cycle", "grid_circular_medium"])
def test_bundled_demonstrations_are_recorded_again_to_the_byte(
    task: str, run: Run, workdir: Path
) -> None:
    status, out, err = run("demos", "record", task, "-o", f"made/{task}.npz")
    ours = bundled(task)
    assert ours is not None
    save("ours.npz", ours)
    assert (status, out) == (0, f"made/{task}.npz\n")
    assert Path(out.strip()).read_bytes() == Path("ours.npz").read_bytes()
    assert "5 episodes" in err


def test_noise_changes_what_is_recorded_and_is_told_in_the_sidecar(run: Run, workdir: Path) -> None:
    for noise in ("0", "0.5"):
        run("demos", "record", "flatworld_cycle", "-n", 2, "--noise", noise, "-o", f"{noise}.npz")
    calm, wild = load("0.npz"), load("0.5.npz")
    assert (calm.meta["noise"], wild.meta["noise"]) == (0.0, 0.5)
    assert calm.episodes[0].observations.tobytes() != wild.episodes[0].observations.tobytes()


@pytest.mark.parametrize("name", ["mine.yaml", "mine.json", "mine", "mine.npz.bak"])
def test_demonstrations_are_written_to_an_npz_only(name: str, run: Run, workdir: Path) -> None:
    Path(name).write_text("mine")
    status, out, err = run("demos", "record", "flatworld_cycle", "-n", 1, "-o", name)
    assert (status, out) == (2, "")
    assert err == f"error: demonstrations are kept as x.npz, not `{name}`\n"
    assert [(p.name, p.read_text()) for p in workdir.iterdir()] == [(name, "mine")]


@pytest.mark.parametrize("content", ["{", "[]", '{"schema_version": 1}'])
def test_a_json_of_something_else_is_not_replaced(
    content: str, run: Run, workdir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(workdir / "datasets"))
    Path("flatworld_cycle.json").write_text(content)
    for how in ((), ("-o", "flatworld_cycle.npz")):
        status, out, err = run("demos", "record", "flatworld_cycle", "-n", 1, *how)
        assert (status, out) == (2, "")
        assert "`flatworld_cycle.json`, which goes beside it, is there already" in err
    ours = bundled("flatworld_cycle")
    assert ours is not None
    save("ours.npz", ours)
    assert run("demos", "convert", "ours.npz", "flat/cycle-v0")[0] == 0
    assert run("demos", "convert", "flat/cycle-v0", "flatworld_cycle.npz")[0] == 2
    assert Path("flatworld_cycle.json").read_text() == content
    assert not Path("flatworld_cycle.npz").exists()


def test_demonstrations_of_ones_own_are_recorded_anew(run: Run, workdir: Path) -> None:
    for count in (2, 1):
        assert run("demos", "record", "flatworld_cycle", "-n", count)[0] == 0
    assert load("flatworld_cycle.npz").meta["steps"][1:] == []


def test_a_task_file_that_is_not_there_is_a_finding(run: Run, workdir: Path) -> None:
    for verb in ("record", "check"):
        status, out, err = run("demos", verb, "nowhere.yaml")
        assert (status, out) == (1, "")
        assert err.startswith("error[SPEC105]: cannot read `nowhere.yaml`")


def test_a_function_of_ones_own_records_the_demonstrations_that_the_task_asks_for(
    run: Run, swing: Path
) -> None:
    status, out, err = run("demos", "record", "swing.yaml", "--expert", "drive.py:drive", "-n", 3)
    assert (status, out) == (0, "swing.npz\n"), err
    status, out, err = run("demos", "check", "swing.yaml")
    assert status == 0
    assert err == "3 of 3 reach acceptance without violation, 0 violate\n"
    head, columns, *rows = out.splitlines()
    assert columns.split() == ["demo", "steps", "visits", "lost", "0", "1", "2*"]
    assert [row.split()[:4] for row in rows] == [
        [str(i), str(load("swing.npz").episodes[i].steps), "1", "-"] for i in range(3)
    ]
    assert "stage" in head


def test_numbered_actions_are_recorded_in_an_environment_of_gymnasium(
    run: Run, swing: Path
) -> None:
    Path("swing.yaml").write_text(LAKE, encoding="utf-8")
    Path("walk.py").write_text("def walk(generator):\n    return lambda cell: 2\n")
    status, out, err = run("demos", "record", "swing.yaml", "--expert", "walk.py:walk", "-n", 1)
    assert (status, out) == (0, "swing.npz\n"), err
    actions = load("swing.npz").episodes[0].actions
    assert actions is not None
    assert actions.dtype.kind == "i"
    assert set(actions.tolist()) == {2}


@pytest.mark.parametrize("action", ["4", "-1", "1.7", "float('nan')", "'1'", "[1, 2]"])
def test_an_action_without_that_number_is_a_finding(action: str, run: Run, swing: Path) -> None:
    Path("swing.yaml").write_text(LAKE, encoding="utf-8")
    Path("walk.py").write_text(f"def walk(generator):\n    return lambda cell: {action}\n")
    status, out, err = run("demos", "record", "swing.yaml", "--expert", "walk.py:walk")
    assert (status, out) == (1, "")
    assert "error[DEMO509]: cannot use the expert `walk.py:walk`: it returned " in err
    assert err.endswith(", which is none of the actions 0 to 3\n")


def test_what_a_function_returns_none_for_is_the_end(run: Run, swing: Path) -> None:
    assert run("demos", "record", "swing.yaml", "--expert", "drive.py:brief", "-n", 1)[0] == 0
    assert [demo.steps for demo in load("swing.npz").episodes] == [7]


def test_rounds_make_demonstrations_longer_and_are_told_in_the_sidecar(
    run: Run, workdir: Path
) -> None:
    for laps in (1, 3):
        out = f"{laps}.npz"
        run("demos", "record", "flatworld_cycle", "-n", 2, "--laps", laps, "-o", out)
    short, long = (load(workdir / f"{laps}.npz") for laps in (1, 3))
    assert (short.meta["laps"], long.meta["laps"]) == (1, 3)
    assert all(2 * a.steps < b.steps for a, b in zip(short.episodes, long.episodes, strict=True))


def test_functions_make_no_rounds(run: Run, swing: Path) -> None:
    how = ("demos", "record", "swing.yaml", "--expert", "drive.py:drive")
    status, _, err = run(*how, "--laps", 2)
    assert status == 1
    assert "error[DEMO509]" in err
    assert "no laps to set" in err


def test_noise_disturbs_a_functions_actions_within_their_bounds(run: Run, swing: Path) -> None:
    how = ("demos", "record", "swing.yaml", "--expert", "drive.py:drive", "-n", 1)
    assert run(*how, "--noise", "0.4")[0] == 0
    actions = load("swing.npz").episodes[0].actions
    assert actions is not None
    assert np.unique(actions).size > 20
    assert np.abs(actions).max() == 1.0


@pytest.mark.parametrize(
    ("expert", "problem"),
    [
        ("drive.py:broken", "it returned [1.0, 2.0], which is no action of shape [1]"),
        ("drive.py:raising", "it raised RuntimeError: no fuel"),
        ("drive.py:dirve", "the file has no function `dirve`"),
        ("none.py:drive", "there is no such file"),
        ("drive:drive", "it is not `file.py:function`"),
    ],
)
def test_a_function_that_cannot_be_used_is_a_finding(
    expert: str, problem: str, run: Run, swing: Path
) -> None:
    status, out, err = run("demos", "record", "swing.yaml", "--expert", expert)
    assert (status, out) == (1, "")
    assert f"error[DEMO509]: cannot use the expert `{expert}`: {problem}" in err
    assert not Path("swing.npz").exists()


@pytest.mark.parametrize(
    ("how", "problem"),
    [
        ("reset", "reset() fails: RuntimeError: no start (weary.py, line 15)"),
        ("step", "step() fails: RuntimeError: no breath (weary.py, line 22)"),
        ("nan", "step() fails: ValueError: an observation that is not finite"),
        ("size", "step() fails: ValueError: an observation of 2 numbers, not 1"),
    ],
)
def test_an_environment_that_fails_is_named_with_its_line_and_nothing_is_kept(
    how: str, problem: str, run: Run, swing: Path
) -> None:
    Path("weary.py").write_text(WEARY, encoding="utf-8")
    named = SWING.replace("MountainCarContinuous-v0", f"weary:Weary-v0\n  kwargs: {{how: {how}}}")
    Path("swing.yaml").write_text(named, encoding="utf-8")
    status, out, err = run("demos", "record", "swing.yaml", "--expert", "drive.py:brief")
    assert (status, out) == (1, "")
    assert err == f"error[RUN707]: the environment `weary:Weary-v0` failed: {problem}\n"
    assert not Path("swing.npz").exists()


@pytest.mark.parametrize("task", ["flatworld_cycle", "swing.yaml"])
def test_a_file_without_its_function_is_no_name_of_an_expert(
    run: Run, swing: Path, task: str
) -> None:
    status, _, err = run("demos", "record", task, "--expert", "drive.py")
    assert status == 1
    assert err == (
        "error[DEMO509]: cannot use the expert `drive.py`: it is not `file.py:function`\n"
        "  = help: name its function too: `drive.py:FUNCTION`\n"
    )


def test_an_expert_that_is_not_there_is_a_finding_that_names_the_known(
    run: Run, workdir: Path
) -> None:
    status, _, err = run("demos", "record", "flatworld_cycle", "--expert", "nobody")
    assert status == 1
    assert "error[DEMO506]" in err
    assert "its experts: stabilization, cycle, disjunction" in err


def test_recorded_actions_are_those_between_the_states(run: Run, workdir: Path) -> None:
    assert run("demos", "record", "flatworld_cycle", "-n", 1, "--noise", 0)[0] == 0
    demo = load("flatworld_cycle.npz").episodes[0]
    assert demo.actions is not None
    moved = np.clip(demo.observations[:-1] + 0.4 * demo.actions, -2, 2)
    np.testing.assert_allclose(moved, demo.observations[1:], atol=1e-6)


def test_a_demonstration_that_violates_is_shown_with_its_step(run: Run, workdir: Path) -> None:
    straight = np.linspace((-1.0, -1.0), (1.0, 1.0), 11, dtype=np.float32)
    np.savez("straight.npz", observations_0=straight)
    status, out, err = run("demos", "check", "flatworld_cycle", "straight.npz")
    assert status == 0, "a warning"
    assert out.splitlines()[2].split() == ["0", "10", "0", "3", "0", "-", "-", "-"]
    assert "warning[DEMO503]: demonstration 0 violates the formula at step 3" in err
    assert err.endswith("0 of 1 reach acceptance without violation, 1 violate\n")


def test_demonstrations_of_another_shape_are_an_error(run: Run, workdir: Path) -> None:
    np.savez("flat.npz", observations_0=np.zeros((4, 3), np.float32))
    status, out, err = run("demos", "check", "flatworld_cycle", "flat.npz")
    assert (status, out) == (1, "")
    assert "error[DEMO504]" in err


def test_all_demonstrations_of_a_named_file_are_checked(run: Run, workdir: Path) -> None:
    run("demos", "record", "flatworld_cycle", "-n", 8)
    assert (
        len(run("demos", "check", "flatworld_cycle", "flatworld_cycle.npz")[1].splitlines()) == 10
    )


def test_without_demonstrations_there_is_nothing_to_check(run: Run, swing: Path) -> None:
    text = SWING.replace("demonstrations:\n  file: swing.npz\n", "")
    Path("swing.yaml").write_text(text, encoding="utf-8")
    assert run("demos", "check", "swing.yaml")[0] != 0


def test_npz_to_minari_and_back(run: Run, workdir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(workdir / "datasets"))
    run("demos", "record", "flatworld_cycle", "-o", "a.npz")
    assert run("demos", "convert", "a.npz", "flat/cycle-v0")[:2] == (0, "flat/cycle-v0\n")
    assert run("demos", "convert", "flat/cycle-v0", "b.npz")[:2] == (0, "b.npz\n")
    assert Path("a.npz").read_bytes() == Path("b.npz").read_bytes()
    assert run("demos", "check", "flatworld_cycle", "flat/cycle-v0")[0] == 0
    assert run("demos", "convert", "flat/cycle-v0", "b.npz")[0] == 2, "it is there already"
    assert run("demos", "convert", "a.npz", "b.npz")[0] == 2
