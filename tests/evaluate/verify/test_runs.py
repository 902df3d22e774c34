"""Runs verified: exact and simulated probabilities, failures that happen, models that lie."""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from safetensors.torch import load_file, save_file

from tests.evaluate.verify import worlds  # registers
from tests.learn.examples import beyond, cell_is, demos, plan
from tests.plan.automata import ring, stabilization
from tiloilc.automaton import translate
from tiloilc.demos import DemoSet
from tiloilc.diag import CompileError
from tiloilc.driver import compile_spec, labeller
from tiloilc.evaluate.protocol import Validator
from tiloilc.evaluate.verify import Verification, Wanted, simulated, verify_run, verify_task
from tiloilc.evaluate.verify.exact import Exact
from tiloilc.learn import train
from tiloilc.ltl import Lasso, holds, parse
from tiloilc.plan import Plan

Task = tuple[Plan, DemoSet, Callable[[Any], Any]]

NAMES = ("goal", "pit")
REACH = "F goal & G !pit"


def gambling(**changes: Any) -> Task:
    """In the gambler's ruin, with time enough for every game to be over."""
    ldba = translate(parse(REACH, NAMES).formula, NAMES)
    made = plan(ldba, "TestsGamble-v0", horizon=100, **changes)
    return dataclasses.replace(made, formula=REACH), DemoSet(()), cell_is(4, 0)


def trained(task: Task, run: Path) -> Path:
    made, shown, labels = task
    run.mkdir()
    train(made, shown, labels, run, Validator(made, labels), lambda seen: None, {})
    return run


def told(run: Path, *columns: int) -> Path:
    """Have the tables of a run's policies prefer one action everywhere, another for each seed."""
    for name in ("best", "last"):
        path = run / "checkpoints" / f"{name}.safetensors"
        arrays = load_file(path)
        for seed, column in enumerate(columns):
            arrays["q"][seed] = 0.0
            arrays["q"][seed, ..., column] = 1.0
        save_file({k: v.contiguous() for k, v in arrays.items()}, path)
    return run


@pytest.fixture
def gambled(tmp_path: Path) -> tuple[Task, Path]:
    """Of two agents the first always plays, the second never does."""
    task = gambling(steps=200)
    return task, told(trained(task, tmp_path / "run"), worlds.PLAY, worlds.STAY)


def exact(found: Verification) -> list[Fraction]:
    assert all(isinstance(judged.found, Exact) for judged in found.judged)
    return [judged.found.probability for judged in found.judged]  # type: ignore[union-attr]


def test_what_storm_says_of_a_policy_a_long_simulation_confirms(
    gambled: tuple[Task, Path],
) -> None:
    task, run = gambled
    known = verify_run(*task, run, Wanted())
    assert exact(known) == [Fraction(9, 10), 0]
    assert known.simulated is None
    assert known.maximum is not None
    assert (known.maximum.probability, known.maximum.exact) == (Fraction(9, 10), True)
    wanted = Wanted(method="simulate", episodes=1000, confidence=0.999)
    played = verify_run(*task, run, wanted)
    for judged, probability in zip(played.judged, exact(known), strict=True):
        bounds = judged.found.bounds  # type: ignore[union-attr]
        assert bounds.low <= probability <= bounds.high
        assert bounds.high - bounds.low < 0.07
    assert played.simulated is not None
    assert played.simulated.pooled.episodes == 2000
    assert played.simulated.alike == (1,), "who never plays sees the same every time"


def test_long_walks_agree_with_what_is_exact_of_a_gamble_too(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    wanted = Wanted(steps=60, episodes=400, confidence=0.999)
    found = verify_run(*task, run, wanted)
    assert exact(found) == [Fraction(9, 10), 0]
    assert found.walked is not None
    assert (found.walked.steps, found.walked.episodes) == (60, 400)
    for judged in found.judged:
        assert judged.walked is not None
        assert judged.walked.episodes == 400
        assert judged.agrees
    lost = [judged.walked.violated for judged in found.judged]  # type: ignore[union-attr]
    assert 0 < lost[0] < 100
    assert lost[1] == 0, "who never plays loses nothing, and wins nothing"
    assert verify_run(*task, run, Wanted()).walked is None


def test_a_walk_that_no_longer_accepts_is_not_fine() -> None:
    accepting = np.zeros((1, 3, 10), np.bool_)
    accepting[0, 0, [2, 7]] = accepting[0, 1, 4] = accepting[0, 2, 5] = True
    violated = np.array([[False, False, True]])
    trials = simulated.Trials(violated, simulated.in_halves(accepting), np.array([False]))
    assert trials.lasting().tolist() == [[True, False, False]]
    assert trials.fine(1).tolist() == [[True, True, False]]
    assert trials.fine(2).tolist() == [[True, False, False]]


def test_no_two_agents_share_an_episode(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    told(run, worlds.PLAY, worlds.PLAY)
    found = verify_run(*task, run, Wanted(method="simulate", episodes=300))
    first, second = (judged.found for judged in found.judged)
    assert first != second, "the same dice would have given the same"


def test_what_is_played_beyond_the_last_episode_does_not_count(
    gambled: tuple[Task, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of three episodes in chunks of two a fourth is played, which differs here from the others."""
    task, run = gambled
    told(run, worlds.PLAY, worlds.PLAY)
    monkeypatch.setattr(simulated, "CHUNK", 2)
    seeds = {0: [1, 1], 2: [1, 2]}
    patched = lambda self, start, count: (2 * seeds[start])[: 2 * count]  # noqa: E731
    monkeypatch.setattr(simulated.Simulation, "_seeds", patched)
    for episodes, alike in ((3, (0, 1)), (4, ())):
        found = verify_run(*task, run, Wanted(method="simulate", episodes=episodes))
        assert found.simulated is not None
        assert found.simulated.alike == alike


def test_a_counterexample_is_the_likeliest_way_or_one_that_was_played(
    gambled: tuple[Task, Path],
) -> None:
    task, run = gambled
    stays, plays = verify_run(*task, run, Wanted()).counterexamples
    assert (stays.seed, plays.seed) == (1, 0), "who does worst is first"
    assert stays.reason == (
        "from step 0 on it stays in one state for ever, in stage 0, and `goal` never becomes true"
    )
    assert plays.path.observations[:, 0].tolist() == [2, 1, 0]
    assert plays.probability == pytest.approx(1 / 16)
    assert "step 2: `pit` became true in stage 0" in plays.reason
    one = Wanted(method="simulate", seed=0, episodes=50)
    (played,) = verify_run(*task, run, one).counterexamples
    seen = played.path.observations[:, 0]
    assert (np.abs(np.diff(seen)) <= 1).all()
    assert seen[-1] == 0
    assert "`pit` became true" in played.reason
    (idle,) = verify_run(*task, run, dataclasses.replace(one, seed=1)).counterexamples
    assert idle.reason.startswith("step 100: the horizon was over with 0 accepting visits")


def test_the_policy_and_the_agent_that_are_named_are_verified(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    path = run / "checkpoints" / "last.safetensors"
    arrays = load_file(path)
    arrays["q"] = arrays["q"].flip(0).contiguous()
    save_file(arrays, path)
    assert exact(verify_run(*task, run, Wanted(policy="last"))) == [0, Fraction(9, 10)]
    assert exact(verify_run(*task, run, Wanted(policy="last", seed=1))) == [Fraction(9, 10)]
    for wanted, said in (
        (Wanted(policy="cloning"), "it has no `cloning`"),
        (Wanted(seed=2), "it has the seeds 0 to 1, not 2"),
    ):
        with pytest.raises(CompileError, match=rf"RUN708.*{said}"):
            verify_run(*task, run, wanted)


def test_as_many_episodes_are_played_as_the_precision_needs(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    found = verify_run(*task, run, Wanted(method="simulate", half_width=0.1))
    assert found.simulated is not None
    assert found.simulated.episodes == found.simulated.needed == 104
    for judged in found.judged:
        bounds = judged.found.bounds  # type: ignore[union-attr]
        assert bounds.high - bounds.low <= 0.2


def test_more_visits_are_harder_to_make(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    wanted = Wanted(method="simulate", seed=0, episodes=60)
    one, many = (
        verify_run(*task, run, dataclasses.replace(wanted, visits=k)).judged[0].probability
        for k in (1, 99)
    )
    assert one > 0.7
    assert many < one, "two steps at least are needed to get there"


def test_an_environment_without_a_model_is_simulated_and_says_why(tmp_path: Path) -> None:
    task = gambling(steps=200, kwargs={"silent": True})
    run = told(trained(task, tmp_path / "run"), worlds.PLAY, worlds.PLAY)
    found = verify_run(*task, run, Wanted(episodes=20))
    assert found.why == "`TestsGamble-v0` publishes no finite model of itself"
    assert (found.simulated is not None, found.maximum) == (True, None)
    with pytest.raises(CompileError, match=r"RUN713.*publishes no finite model"):
        verify_run(*task, run, Wanted(method="exact"))
    assert verify_task(task[0], task[2], None, Wanted()).maximum is None


def test_a_model_that_its_environment_belies_is_refused(tmp_path: Path) -> None:
    task = gambling(steps=200, kwargs={"liar": True})
    with pytest.raises(CompileError, match=r"RUN714.*step \d+ of an episode shows \d, which"):
        verify_task(task[0], task[2], None, Wanted())


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"probability": np.ones((5, 2, 2))}, "`probability` has probabilities that do not sum"),
        ({"probability": np.full((5, 2, 2), np.nan)}, "`probability` has probabilities that do"),
        ({"initial": np.ones(5)}, "`initial` has probabilities that do not sum to 1"),
        ({"successor": np.full((5, 2, 2), 5)}, "`successor` leads out of the states 0 to 4"),
        ({"successor": np.zeros((5, 2), int)}, "are not both"),
        ({"actions": np.arange(3)}, "`actions` are not 2"),
        ({"actions": np.array([1, 2])}, r"not those of its action space, Discrete\(2\)"),
        ({"observations": np.zeros((4, 1))}, "are not of 5 states"),
    ],
)
def test_what_is_no_model_is_refused(
    changes: dict[str, Any], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = dataclasses.replace(worlds.gamble(), **changes)
    monkeypatch.setattr(worlds.Gamble, "markov_model", lambda self: broken)
    task = gambling()
    with pytest.raises(CompileError, match=f"RUN714.*{said}"):
        verify_task(task[0], task[2], None, Wanted())


def test_an_end_of_the_environment_must_be_one_of_its_model(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    step = worlds.Gamble.step

    def ends(self: worlds.Gamble, action: int) -> Any:
        return (*step(self, action)[:2], self.place in self.final, False, {})

    task = gambling()
    monkeypatch.setattr(worlds.Gamble, "step", ends)
    monkeypatch.setattr(worlds.Gamble, "final", (0, 4), raising=False)
    maximum = verify_task(task[0], task[2], None, Wanted()).maximum
    assert maximum is not None
    assert maximum.probability == Fraction(9, 10)
    monkeypatch.setattr(worlds.Gamble, "final", (0, 3))
    with pytest.raises(CompileError, match=r"RUN714.*ends it, and there the model goes on"):
        verify_task(task[0], task[2], None, Wanted())


def test_an_environment_that_fails_or_publishes_something_else_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    task = gambling()
    with monkeypatch.context() as patch:
        patch.setattr(worlds.Gamble, "markov_model", lambda self: "odd")
        with pytest.raises(CompileError, match=r"RUN714.*publishes str"):
            verify_task(task[0], task[2], None, Wanted())
    monkeypatch.setattr(worlds.Gamble, "step", lambda self, action: 1 / 0)
    with pytest.raises(CompileError, match=r"RUN707.*ZeroDivisionError"):
        verify_task(task[0], task[2], None, Wanted())


def test_without_storm_nothing_is_exact(
    gambled: tuple[Task, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    task, run = gambled
    monkeypatch.setitem(sys.modules, "stormpy", None)
    with pytest.raises(CompileError, match=r"RUN713.*`stormpy` is not installed"):
        verify_run(*task, run, Wanted())
    found = verify_run(*task, run, Wanted(method="simulate", episodes=5))
    assert found.maximum is None


def test_past_the_limit_of_time_nothing_is_exact(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    help = "bound a run's policies with --method simulate, or give Storm a longer --time-limit"
    for verify in (
        lambda wanted: verify_run(*task, run, wanted),
        lambda wanted: verify_task(task[0], task[2], None, wanted),
    ):
        with pytest.raises(CompileError, match=r"RUN713.*Storm takes longer than 0 s") as caught:
            verify(Wanted(time_limit=0))
        assert [about.help for about in caught.value.diagnostics] == [help]
    found = verify_run(*task, run, Wanted(method="simulate", episodes=5, time_limit=0))
    assert found.maximum is None


def test_a_run_that_is_not_finished_is_not_verified(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    (run / "checkpoints" / "last.safetensors").unlink()
    with pytest.raises(CompileError, match="RUN706"):
        verify_run(*task, run, Wanted())


def test_networks_are_simulated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)
    made = plan(stabilization(), "TestsDrift-v0", steps=90)
    shown = demos([[0.1 * t, 0.0] for t in range(8)])
    task = made, shown, beyond(0.4, 1.5)
    found = verify_run(*task, trained(task, tmp_path / "run"), Wanted(episodes=30))
    assert found.simulated is not None
    assert found.simulated.pooled.episodes == 60
    assert found.simulated.alike == ()
    assert json.loads(json.dumps(found.to_json()))["method"] == "simulated"


GRID = """\
name: corridor
environment: {{id: tiloilc/{world}, horizon: {horizon}}}
propositions:
{propositions}
formula: "{formula}"
demonstrations: {{source: expert, count: 3}}
train: {{steps: {steps}, seeds: 3, learning_starts: 200}}
"""

FLAT = """\
name: stay
environment: {id: tiloilc/FlatWorld-v0, horizon: 50}
propositions:
  y: dist(pos, [-0.85, 0.15]) < 0.3
  b: norm(pos) < 0.8
formula: "F G y & G !b"
train: {steps: 20_000}
"""

AVOID = GRID.format(
    world="GridAvoid-v0",
    horizon=17,
    propositions="  a: x >= 7 and y == 0\n  z: y != 0",
    formula="F a & G !z",
    steps=1500,
)


def of_grid(folder: Path, text: str) -> tuple[Task, Path]:
    (folder / "task.yaml").write_text(text, encoding="utf-8")
    result = compile_spec(folder / "task.yaml")
    task = result.plan, result.demos, labeller(result.plan)
    return task, trained(task, folder / "run")


def replayed(task: Plan, labels: Any, columns: Callable[[Any], int], steps: int) -> list[int]:
    """The letters of an episode in the environment itself."""
    env = gym.make(task.environment.id, max_episode_steps=-1, **task.environment.kwargs)
    seen = [env.reset(seed=7)[0]]
    for _ in range(steps):
        seen.append(env.step(columns(seen[-1]))[0])
    return labels(np.array(seen, np.float32)).tolist()


def test_converged_policies_of_a_grid_satisfy_for_certain_as_a_long_walk_does(
    tmp_path: Path,
) -> None:
    task, run = of_grid(tmp_path, AVOID)
    found = verify_run(*task, run, Wanted())
    assert exact(found) == [1, 1, 1]
    assert found.counterexamples == ()
    assert found.maximum is not None
    assert found.maximum.probability == 1
    longer = task[0].environment.model_copy(update={"horizon": 400})
    walk = dataclasses.replace(task[0], environment=longer)
    many = Wanted(method="simulate", episodes=40, visits=300)
    played = verify_run(walk, *task[1:], run, many)
    assert [judged.probability for judged in played.judged] == [1, 1, 1]
    assert all(judged.found.bounds.high == 1 for judged in played.judged)  # type: ignore[union-attr]


@pytest.mark.parametrize(("column", "what"), [(1, "z"), (2, "loop")])
def test_the_counterexample_of_a_failing_grid_policy_happens_in_the_environment(
    tmp_path: Path, column: int, what: str
) -> None:
    task, run = of_grid(tmp_path, AVOID.replace("steps: 1500", "steps: 400"))
    made, _, labels = task
    told(run, column, column, column)
    found = verify_run(*task, run, Wanted())
    assert exact(found) == [0, 0, 0]
    shown = found.counterexamples[0].path
    letters = replayed(made, labels, lambda seen: column, len(shown.letters) + 20)
    assert letters[: len(shown.letters)] == shown.letters.tolist()
    assert made.ldba.run(shown.letters.tolist()) == shown.states.tolist()
    assert shown.loop is not None
    loop = shown.letters[shown.loop :].tolist()
    period = len(loop)
    after = letters[shown.loop :]
    assert all(letter == loop[i % period] for i, letter in enumerate(after))
    lasso = Lasso(tuple(shown.letters[: shown.loop].tolist()), tuple(loop))
    assert not holds(parse(made.formula).formula, lasso, made.ldba.propositions)
    assert (shown.lost(made.ldba) == 1) == (what == "z")
    assert ("`z` became true" if what == "z" else "stays in one state") in found.counterexamples[
        0
    ].reason


def test_where_jumps_take_a_step_the_chain_has_none_of_their_time(tmp_path: Path) -> None:
    """`FG goal & G !pit`: the agent that plays comes to stay, and may jump before it is there."""
    goal_first = stabilization()
    made = plan(goal_first, "TestsGamble-v0", horizon=120, steps=200, epsilon="step")
    task = made, DemoSet(()), cell_is(4, 0)
    run = told(trained(task, tmp_path / "run"), worlds.PLAY, worlds.STAY)
    known = verify_run(*task, run, Wanted())
    wanted = Wanted(method="simulate", episodes=300, confidence=0.999, visits=40)
    for judged, exactly in zip(verify_run(*task, run, wanted).judged, known.judged, strict=True):
        bounds = judged.found.bounds  # type: ignore[union-attr]
        assert bounds.low <= exactly.found.accepted <= bounds.high  # type: ignore[union-attr]


def test_of_a_task_alone_its_expert_is_watched_where_no_maximum_is_exact(tmp_path: Path) -> None:
    (tmp_path / "task.yaml").write_text(FLAT, encoding="utf-8")
    made = compile_spec(tmp_path / "task.yaml").plan
    heard: list[str] = []
    wanted = Wanted(episodes=30)
    found = verify_task(made, labeller(made), "stabilization", wanted, heard.append)
    assert heard == ["playing 30 episodes of the expert `stabilization`"]
    assert found.simulated is not None
    assert found.simulated.pooled.fine == 30
    assert found.maximum is not None
    assert (found.maximum.probability, found.maximum.exact) == (1, False)
    assert found.maximum.how.startswith("Storm on 1,677 states and 81 actions; a lattice of")
    many = dataclasses.replace(wanted, visits=60)
    assert verify_task(made, labeller(made), "stabilization", many).simulated.pooled.fine == 0  # type: ignore[union-attr]


def test_two_rounds_of_a_cycle_are_no_counterexample(tmp_path: Path) -> None:
    """A policy that goes round for ever has probability 1 though no episode shows for ever."""
    ldba = ring(["goal"], "pit")
    made = plan(ldba, "TestsGamble-v0", horizon=10, steps=200, seeds=1)
    task = made, DemoSet(()), cell_is(2, 0)
    run = told(trained(task, tmp_path / "run"), worlds.STAY)
    assert exact(verify_run(*task, run, Wanted())) == [1]


def test_verifying_twice_gives_the_same(gambled: tuple[Task, Path]) -> None:
    task, run = gambled
    for wanted in (Wanted(), Wanted(method="simulate", episodes=30)):
        first, second = (verify_run(*task, run, wanted).to_json() for _ in range(2))
        assert first == second
