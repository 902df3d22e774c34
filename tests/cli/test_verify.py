"""verify from the command line: what is printed and written, statuses, wrong usage."""

import json
from pathlib import Path

import pytest
from safetensors.torch import load_file, save_file

from tests.cli.running import Run, runner
from tiloilc import load_policy
from tiloilc.evaluate import read

CORRIDOR = """\
name: corridor
environment: {id: tiloilc/GridAvoid-v0, horizon: 17}
propositions:
  a: x >= 7 and y == 0
  z: y != 0
formula: "F a & G !z"
demonstrations: {source: expert, count: 3}
train: {steps: 300, seeds: 2, learning_starts: 100}
"""

LAKE = """\
name: lake
environment: {id: FrozenLake-v1, horizon: 100}
observation: {cell: 0}
propositions:
  goal: cell == 15
formula: "F goal"
train: {steps: 20_000}
"""

CAR = """\
name: car
environment: {id: MountainCarContinuous-v0, horizon: 20}
observation: {position: 0, velocity: 1}
propositions:
  top: position > 0.45
formula: "F top"
train: {steps: 20_000}
"""

CLONED = """\
name: cloned
environment: {id: tiloilc/FlatWorld-v0, horizon: 12}
propositions:
  y: dist(pos, [-0.85, 0.15]) < 0.3
  b: norm(pos) < 0.8
formula: "F y & G !b"
demonstrations: {source: expert, count: 2, actions: inferred}
train: {algorithm: cloning, steps: 200, seeds: 1, learning_starts: 60}
evaluate: {episodes: 2, every: 100}
"""

EAST, NORTH = 0, 1
RUN = Path("runs/corridor/0001")


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.fixture
def trained(workdir: Path, run: Run) -> Path:
    """A run whose first agent goes east for ever, and whose second one leaves the corridor."""
    (workdir / "corridor.yaml").write_text(CORRIDOR, encoding="utf-8")
    assert run("compile", "corridor.yaml", "-q")[0] == 0
    assert run("train", "build/corridor", "-q")[0] == 0
    path = RUN / "checkpoints" / "best.safetensors"
    arrays = load_file(path)
    for seed, column in enumerate((EAST, NORTH)):
        arrays["q"][seed] = 0.0
        arrays["q"][seed, ..., column] = 1.0
    save_file(arrays, path)
    return RUN


def test_exact_probabilities_are_printed_written_and_drawn(trained: Path, run: Run) -> None:
    status, out, err = run("verify", trained)
    assert status == 0
    assert out == (
        "corridor: F a & G !z\n"
        "policy `best`, without a time limit: exact, by Storm\n"
        "  seed  probability           its Markov chain\n"
        "     0  1                     18 states\n"
        "     1  0                     4 states\n"
        "any policy at most: 1 (Storm on 126 states and 5 actions)\n"
        "how seed 1 fails:\n"
        "  step 0: stage 0\n"
        "  step 1: `z` became true in stage 0: the formula can no longer be satisfied\n"
    )
    assert err == f"wrote {trained}/verify.json\nwrote {trained}/counterexample.svg\n"
    written = json.loads((trained / "verify.json").read_text())
    assert written["method"] == "exact"
    assert [agent["fraction"] for agent in written["agents"]] == ["1", "0"]
    shown = written["counterexamples"][0]
    assert (shown["seed"], shown["lost_at"]) == (1, 1)
    assert shown["steps"][1] == {
        "step": 1, "observation": [0.0, 1.0], "true": ["z"], "state": 2, "stage": None,
    }  # fmt: skip
    picture = (trained / "counterexample.svg").read_text()
    assert "how the policy `best` of seed 1 fails:" in picture
    assert "`z` became true in stage 0" in picture


def test_walks_are_told_beside_what_is_exact_and_recorded(trained: Path, run: Run) -> None:
    asked = ("verify", trained, "--walk", "50", "--episodes", "8", "-q")
    status, out, err = run(*asked, "--record", "r.jsonl.gz")
    assert (status, out) == (1, "")
    assert f"evaluate it first: tiloilc eval {trained}" in err
    assert run("eval", trained, "-q")[0] == 0
    status, out, err = run(*asked, "--record", "r.jsonl.gz")
    assert (status, err) == (0, "")
    assert out.startswith(
        "corridor: F a & G !z\n"
        "policy `best`, without a time limit: exact, by Storm\n"
        "beside 8 walks of 50 steps, fine without violation and with an accepting visit in the"
        " second half\n"
        "  seed  probability           its Markov chain    fine walks  95 % bounds\n"
        "     0  1                     18 states                  8/8  0.6306 – 1.0000\n"
        "     1  0                     4 states                   0/8  0.0000 – 0.3694\n"
    )
    first, second = (record.fields for record in read(Path("r.jsonl.gz")))
    assert (first["seed"], first["name"], first["algorithm"]) == (0, "corridor", "tiloil")
    assert first["steps"] == 300
    assert first["walked"] == {"confidence": 0.95, "episodes": 8, "steps": 50}
    assert (first["reason"], first["verified"]["fraction"]) == (None, "1")  # type: ignore[index,call-overload]
    assert str(second["reason"]).startswith("step 1: `z` became true in stage 0")
    assert run(*asked, "--record", "r.jsonl.gz", "--seed", "1")[0] == 0
    assert len(read(Path("r.jsonl.gz"))) == 2, "an agent is recorded once"
    simulate = ("verify", trained, "--method", "simulate", "--episodes", "8", "-q")
    assert run(*simulate, "--record", "s.jsonl.gz")[0] == 0
    played = read(Path("s.jsonl.gz"))[0].fields
    assert played["trials"] == {"confidence": 0.95, "horizon": 17, "visits": 1}
    assert played["walked"] is None


def test_json_on_standard_output_is_what_is_written(trained: Path, run: Run) -> None:
    status, out, _ = run("verify", trained, "--format", "json", "-q")
    assert status == 0
    assert json.loads(out) == json.loads((trained / "verify.json").read_text())


def test_a_check_fails_if_one_agent_does_not_reach_it(trained: Path, run: Run) -> None:
    assert run("verify", trained, "-q", "--at-least", "0")[0] == 0
    status, _, err = run("verify", trained, "--at-least", "0.5")
    assert status == 1
    assert err.endswith("at least 0.5: not shown of seed 1\n")
    status, _, err = run("verify", trained, "--at-least", "1", "--seed", "0")
    assert status == 0
    assert err.endswith("at least 1: yes\n")


def test_a_check_by_simulation_asks_for_what_the_bounds_show(trained: Path, run: Run) -> None:
    asked = ("verify", trained, "--method", "simulate", "--seed", "0", "-q")
    status, out, _ = run(*asked, "--episodes", "50", "--at-least", "0.95")
    assert status == 1, "all fifty are fine, and yet 0.95 is not shown"
    assert "     0       50/50      0 (≤ 0.0711)       1.0000  0.9289 – 1.0000\n" in out
    assert "all episodes passed the same automaton states at the same steps: seeds 0\n" in out
    assert run(*asked, "--episodes", "80", "--at-least", "0.95")[0] == 0
    assert run(*asked, "--episodes", "50", "--confidence", "0.8", "--at-least", "0.95")[0] == 0


def test_the_counterexample_goes_where_it_is_told_and_an_old_one_away(
    trained: Path, run: Run
) -> None:
    assert run("verify", trained, "-q", "-o", "pictures/x.png")[0] == 0
    assert Path("pictures/x.png").read_bytes().startswith(b"\x89PNG")
    assert run("verify", trained, "-q")[0] == 0
    assert (trained / "counterexample.svg").is_file()
    assert run("verify", trained, "-q", "--seed", "0")[0] == 0
    assert not (trained / "counterexample.svg").exists()


def test_a_walk_goes_on_where_the_environment_ends_as_its_model_does(
    workdir: Path, run: Run
) -> None:
    dry = LAKE.replace("id: FrozenLake-v1", "id: FrozenLake-v1, kwargs: {is_slippery: false}")
    (workdir / "lake.yaml").write_text(dry.replace("20_000", "4_000, seeds: 1"), encoding="utf-8")
    assert run("run", "lake.yaml", "-q")[0] == 0
    status, out, _ = run("verify", "runs/lake/0001", "--walk", 100, "--episodes", 20, "-q")
    assert status == 0
    row = next(line.split() for line in out.splitlines() if line.split()[0] == "0")
    assert row[:5] == ["0", "1", "7", "states", "20/20"]
    (agent,) = json.loads(Path("runs/lake/0001/verify.json").read_text())["agents"]
    assert agent["agrees"]
    err = run("verify", "runs/lake/0001", "-o", "x.svg")[2]
    assert "nothing drawn in `x.svg`: there is no counterexample" in err
    assert not Path("x.svg").exists()


def test_where_nothing_was_validated_the_last_policy_is_meant(
    workdir: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)
    (workdir / "cloned.yaml").write_text(CLONED, encoding="utf-8")
    path = Path("runs/cloned/0001")
    assert run("run", "cloned.yaml", "-q")[0] == 0
    assert not (path / "checkpoints/best.safetensors").exists()
    status, out, err = run("verify", path, "--episodes", 2, "-q")
    assert status == 0, err
    assert "policy `last`" in out
    assert load_policy(path).seed == 0
    status, _, err = run("verify", path, "--policy", "best")
    assert status == 1
    assert "it has no `best`" in err


def test_of_a_task_the_most_that_can_be_reached_is_told(workdir: Path, run: Run) -> None:
    (workdir / "lake.yaml").write_text(LAKE, encoding="utf-8")
    lines = (
        "lake: F goal\nany policy at most: 0.823529 = 14/17 (Storm on 21 states and 4 actions)\n"
    )
    status, out, err = run("verify", "lake.yaml")
    assert (status, out, err) == (0, lines, "")
    assert run("verify", "lake.yaml", "--at-least", "0.82", "-q")[0] == 0
    assert run("verify", "lake.yaml", "--at-least", "0.83", "-q")[0] == 1
    status, out, _ = run("verify", "grid_avoid_easy", "--format", "json")
    assert status == 0
    assert json.loads(out)["maximum"]["fraction"] == "1"


def test_of_a_task_without_a_model_it_is_told_why_nothing_is_known(workdir: Path, run: Run) -> None:
    (workdir / "car.yaml").write_text(CAR, encoding="utf-8")
    status, out, _ = run("verify", "car.yaml")
    assert (status, out) == (
        0,
        "car: F top\n"
        "nothing is known of what any policy could reach:"
        " `MountainCarContinuous-v0` publishes no finite model of itself\n",
    )
    assert run("verify", "car.yaml", "--at-least", "0.1")[0] == 1


def test_wrong_usage_is_told_in_a_line(workdir: Path, run: Run) -> None:
    for arguments, said in (
        (("nowhere",), "there is no `nowhere`"),
        (("grid_avoid_easy", "--seed", "3"), "--seed is about a run"),
        (("grid_avoid_easy", "--record", "x.jsonl.gz"), "--record is about a run"),
        ((".", "--walk", "9", "--method", "simulate"), "--walk goes beside what is exact"),
        (("grid_avoid_easy", "-o", "x.gif"), "x.svg or x.png, not `x.gif`"),
        (("grid_avoid_easy", "--time-limit", "inf"), "Invalid value for '--time-limit'"),
        ((".",), "no plan in `.`"),
    ):
        status, out, err = run("verify", *arguments)
        assert (status, out) == (2, ""), arguments
        assert said in err
