"""A saved policy acts as the agent did that was trained, whoever runs it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import onnxruntime
import pytest
from safetensors.numpy import load_file, save_file

import tiloilc
import tiloilc.tasks  # registers
from tests.cli.running import runner
from tiloilc.cli.jobs import open_job
from tiloilc.demos import DemoSet
from tiloilc.deploy import Policy
from tiloilc.deploy.actor import Table
from tiloilc.diag import CompileError
from tiloilc.evaluate.protocol import VALIDATION
from tiloilc.evaluate.rollout import Arena, Rollout
from tiloilc.learn import last_events, load_policy, make_loop

TABLE = """\
name: {name}
environment: {{id: tiloilc/GridCircular-v0, kwargs: {{zones: 2}}, horizon: 40}}
propositions:
  a: 15 <= x <= 19 and 8 <= y <= 12
  b: 8 <= x <= 12 and 15 <= y <= 19
  z: 7 <= x <= 13 and 7 <= y <= 13
formula: "{formula}"
demonstrations: {{source: expert, count: 2, max_visits: 1, actions: inferred}}
train: {{steps: 600, seeds: 3, first_seed: 4, learning_starts: 20, {more}}}
evaluate: {{episodes: 2, every: 300}}
"""

NETWORKS = """\
name: {name}
environment: {{id: tiloilc/FlatWorld-v0, horizon: 20}}
propositions:
  y: dist(pos, [-0.85, 0.15]) < 0.5
  r: dist(pos, [0.45, -0.75]) < 0.5
  b: norm(pos) < 0.6
formula: "{formula}"
demonstrations: {{source: expert, count: 2, actions: none}}
train:
  steps: 260
  seeds: 3
  first_seed: 4
  learning_starts: 60
  actor_hidden: [16, 16]
  critic_hidden: [16, 16]
  batch_size: 16
  {more}
evaluate: {{episodes: 2, every: 100}}
"""

TASKS = {
    "rounds": (TABLE, "G F (a & X F b) & G !z", ""),
    "settling": (TABLE, "F G a & G !z", "accepting_target: live, entropy: 0.3"),
    "potential": (TABLE, "F G a & G !z", "algorithm: drl2"),
    "stay": (NETWORKS, "F G y & G !b", "accepting_target: live"),
    "reach": (NETWORKS, "F y & G !b", "layer_norm: false"),
}
"""Tables and networks, with ε-jumps (all that settle or stay) and without; a method by whose
potential it matters where a jump arrives."""

CLONED = (
    NETWORKS.replace("actions: none", "actions: inferred"),
    "(F G y | F G r) & G !b",
    "warm_start_steps: 10_000",
)
"""Whoever clones does not jump where no demonstration was."""


def trained(folder: Path, name: str, task: tuple[str, str, str]) -> Iterator[Path]:
    """A finished run in `folder`, which is where we are meanwhile."""
    text, formula, more = task
    (folder / "task.yaml").write_text(
        text.format(name=name, formula=formula, more=more), encoding="utf-8"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for arguments in (["compile", "task.yaml", "-q"], ["train", f"build/{name}", "-q"]):
            with pytest.raises(SystemExit, match="0"):
                tiloilc.cli.main(arguments)
        yield folder / "runs" / name / "0001"


@pytest.fixture(scope="module", params=TASKS)
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A finished run."""
    yield from trained(tmp_path_factory.mktemp(request.param), request.param, TASKS[request.param])


@pytest.fixture(scope="module")
def grid(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A finished run of a table."""
    yield from trained(tmp_path_factory.mktemp("grid"), "grid", TASKS["rounds"])


@pytest.fixture(scope="module")
def cloned(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A finished run that began by cloning."""
    yield from trained(tmp_path_factory.mktemp("cloned"), "cloned", CLONED)


def rollout(run: Path, name: str) -> Rollout:
    """What the training code's agent does in two episodes of each seed."""
    with open_job(run) as job:
        agent = make_loop(job.plan, DemoSet(job.demos.episodes), job.labels).agent
        state = load_policy(run, name)
        assert state is not None
        agent.load_policy(state)
        arena = Arena(job.plan, job.labels, 2)
        return arena.play(agent, range(VALIDATION, VALIDATION + 2))


def walked(policy: Policy) -> tuple[np.ndarray[Any, Any], list[int], int]:
    """The same in an ordinary loop: observations, automaton states and visits."""
    about = policy.plan.environment
    env = gymnasium.make(about.id, max_episode_steps=about.horizon, **about.kwargs)
    observation, _ = env.reset(seed=VALIDATION)
    seen, states = [observation], []
    policy.reset()
    truncated = False
    while not truncated:
        action = policy.act(observation)
        states.append(policy.state)
        observation, _, _, truncated, _ = env.step(action)
        seen.append(observation)
    policy.observe(observation)
    return np.array(seen), [*states, policy.state], policy.visits


def test_a_dictionary_of_arrays_is_read_as_the_flat_observation_is(run: Path) -> None:
    policy = tiloilc.load_policy(run)
    policy.plan = replace(policy.plan, fields={"rest": (1, 2), "first": (0, 1)})
    flat = np.array([3.0, 0.5], np.float32)
    assert policy.observe({"rest": np.array([0.5]), "first": 3}).tolist() == [flat.tolist()]


@pytest.mark.parametrize(
    "observation",
    [{"place": 0.5, "switch": 1}, {"place": 0.5}, {"switch": np.ones(1)}, {"place": [1, 2]}, {}],
)
def test_a_dictionary_that_does_not_fill_an_observation_is_not_guessed_at(
    run: Path, observation: dict[str, object]
) -> None:
    """A choice (Discrete) is one number in its dictionary and several to the networks."""
    policy = tiloilc.load_policy(run)
    policy.plan = replace(policy.plan, fields={"place": (0, 1), "switch": (1, 4)})
    with pytest.raises(ValueError, match=r"does not fill .*'switch': 3.*flatten\(env"):
        policy.act(observation)


@pytest.mark.parametrize(
    ("observation", "said"),
    [
        (0.5, "of 1 number, the policy reads 2"),
        (None, "of 1 number, the policy reads 2"),
        ([], "of 0 numbers, the policy reads 2"),
        (np.zeros((2, 2)), "of 4 numbers, the policy reads 2"),
        ([np.nan, 0], "entries that are not finite"),
        ([0, np.inf], "entries that are not finite"),
    ],
)
def test_what_is_no_observation_of_the_task_is_refused(
    run: Path, observation: object, said: str
) -> None:
    policy = tiloilc.load_policy(run)
    before = policy.state
    with pytest.raises(ValueError, match=f"an observation.*{said}"):
        policy.act(observation)
    assert policy.state == before


@pytest.mark.parametrize(
    ("low", "sizes", "observations", "said"),
    [
        ([0], [16], [99, -1, -0.5, 1e30], "an observation outside 0…15"),
        ([1], [4], [0, 5], "an observation outside 1…4"),
        ([0, 1], [20, 5], [(20, 1), (0, 0), (-1, 3)], "an observation outside [0, 1]…[19, 5]"),
    ],
)
def test_a_place_that_a_table_does_not_have_is_refused(
    grid: Path, low: list[int], sizes: list[int], observations: list[object], said: str
) -> None:
    policy = tiloilc.load_policy(grid)
    assert isinstance(policy.actor, Table)
    policy.actor = replace(policy.actor, low=np.array(low), sizes=np.array(sizes))
    before = policy.state
    for observation in observations:
        with pytest.raises(ValueError, match=f"^{re.escape(said)}$"):
            policy.act(observation)
    assert policy.state == before


def test_a_table_reads_its_corners_and_networks_anything(grid: Path, cloned: Path) -> None:
    policy = tiloilc.load_policy(grid)
    assert [policy.act(corner) >= 0 for corner in policy.actor.limits] == [True, True]
    assert np.isfinite(tiloilc.load_policy(cloned).act([1e9, -1e9])).all()


def test_a_policy_is_shown_without_its_weights(run: Path) -> None:
    policy = tiloilc.load_policy(run, seed=5)
    assert repr(policy) == f"Policy(seed=5, state={policy.state}, visits=0)"


@pytest.mark.parametrize("name", ["best", "last"])
def test_a_loaded_policy_does_what_the_trained_agent_did(run: Path, name: str) -> None:
    does_as_trained(run, name)


@pytest.mark.parametrize("name", ["best", "last", "cloning"])
def test_a_cloned_policy_jumps_as_the_trained_agent_did(cloned: Path, name: str) -> None:
    does_as_trained(cloned, name)


def does_as_trained(run: Path, name: str) -> None:
    expected = rollout(run, name)
    for place, seed in enumerate((4, 5, 6)):
        policy = tiloilc.load_policy(run, seed=seed, policy=name)
        observations, states, visits = walked(policy)
        np.testing.assert_allclose(observations, expected.observations[place], atol=1e-5)
        assert states == expected.states[place, 0].tolist()
        assert visits == expected.accepting[place, 0, 1:].sum()


def test_without_a_seed_the_best_by_validation_is_taken(run: Path) -> None:
    best: dict[int, tuple[float, float]] = {}
    for event in last_events(run / "events.jsonl", "eval"):
        if event["step"] > 60:  # type: ignore[operator]
            greedy: dict[str, list[float]] = event["greedy"]  # type: ignore[assignment]
            for seed in range(3):
                score = (greedy["accepting_visits"][seed], -greedy["violation_rate"][seed])
                best[seed] = max(best.get(seed, (-1.0, -1.0)), score)
    wanted = max(range(3), key=lambda seed: best[seed])
    assert tiloilc.load_policy(run).seed == 4 + wanted


def test_the_exported_model_gives_the_same_actions_and_values(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert runner(capsys)("export", run, "-o", out, "--seed", 5, "-q") == (0, f"{out}\n", "")
    policy = tiloilc.load_policy(run, seed=5)
    rng = np.random.default_rng(0)
    states = policy.walk.states
    if "table" in type(policy.actor).__name__.lower():
        observations = rng.integers(0, 21, (400, 2)).astype(np.float32)
    else:
        observations = rng.uniform(-2, 2, (400, 2)).astype(np.float32)
    state = rng.integers(0, states, 400)
    session = onnxruntime.InferenceSession(out / "policy.onnx")
    given = {"observation": observations, "state": state}
    names = [output.name for output in session.get_outputs()]
    assert names == ["action", "value"] if policy.walk.chooses else ["action"]
    found = dict(zip(names, session.run(None, given), strict=True))
    expected = policy.actor.act(observations, state)
    assert found["action"].shape == expected.shape
    np.testing.assert_allclose(found["action"], expected, atol=1e-5)
    if policy.walk.chooses:
        values = policy.actor.values(observations, state)
        np.testing.assert_allclose(found["value"], values, rtol=1e-5, atol=1e-5)


def test_an_export_is_steered_by_its_tables_alone(run: Path, tmp_path: Path) -> None:
    """As `how` in policy.json says, without tiloilc."""
    from tiloilc.deploy import export

    policy = tiloilc.load_policy(run)
    export(policy, tmp_path)
    about = json.loads((tmp_path / "policy.json").read_text())
    session = onnxruntime.InferenceSession(tmp_path / about["model"]["file"])
    automaton = about["automaton"]

    def ask(observation: np.ndarray[Any, Any], state: int) -> dict[str, Any]:
        given = {
            "observation": np.float32(observation)[None],
            "state": np.array([state], np.int64),
        }
        names = [output.name for output in session.get_outputs()]
        return dict(zip(names, session.run(None, given), strict=True))

    def step(state: int, letter: int, observation: np.ndarray[Any, Any]) -> int:
        def matches(row: dict[str, Any]) -> bool:
            return any(letter & mask == value for mask, value in row["cubes"])

        for option in automaton["options"]:
            if option["state"] == state and matches(option):
                targets: list[int] = option["targets"]
                return max(targets, key=lambda b: ask(observation, b)["value"][0])
        (edge,) = (e for e in automaton["edges"] if e["source"] == state and matches(e))
        return int(edge["target"])

    observations, states, _ = walked(policy)
    state = automaton["initial"]
    for seen, expected in zip(observations, states, strict=True):
        letter = int(policy.labels(seen[None])[0])
        state = step(state, letter, seen)
        assert state == expected
    assert [p["name"] for p in about["propositions"]] == list(policy.plan.ldba.propositions)
    assert (tmp_path / "automaton.hoa").read_text().startswith("HOA: v1")


def test_the_same_policy_is_exported_to_the_same_bytes(run: Path, tmp_path: Path) -> None:
    from tiloilc.deploy import EXPORTED, export

    for place in ("one", "two"):
        export(tiloilc.load_policy(run), tmp_path / place)
    for name in EXPORTED:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_policy_of_another_version_is_a_finding(run: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy" / "runs" / "task" / "0001"
    shutil.copytree(run, copy)
    path = copy / "checkpoints" / "best.safetensors"
    arrays = load_file(path)
    save_file({name: array for name, array in arrays.items() if name != "arrival.pay"}, path)
    with pytest.raises(CompileError, match=r"RUN701.*best.safetensors has no 'arrival.pay'"):
        tiloilc.load_policy(copy)


def test_a_policy_needs_no_torch(run: Path, root: Path) -> None:
    program = (
        "import sys, tiloilc\n"
        f"tiloilc.load_policy({str(run)!r}).act([1.0, 1.0])\n"
        "assert 'torch' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=root, check=False, timeout=60)
    assert done.returncode == 0


def test_without_onnx_export_says_what_to_install(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tiloilc.cli.export.find_spec", lambda name: None)
    status, out, err = runner(capsys)("export", tmp_path)
    assert (status, out) == (2, "")
    assert "pip install 'tiloilc[onnx]'" in err


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"seed": 3}, "RUN708.*seeds 4 to 6, not 3"),
        ({"policy": "first"}, "RUN708.*`best` and `last`, no `first`"),
        ({"policy": "cloning"}, "RUN708.*no `cloning`"),
    ],
)
def test_what_is_not_there_is_a_finding(run: Path, given: dict[str, Any], said: str) -> None:
    with pytest.raises(CompileError, match=said):
        tiloilc.load_policy(run, **given)
