"""The task files of the Fetch tasks, their experts and their demonstrations."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tests.tasks.robots.arms import IDS, SPECS, by_hand, make, moves, rollout, states
from tiloilc.automaton import translate
from tiloilc.automaton.ldba import Ldba
from tiloilc.demos import bundled, record, replay, save
from tiloilc.demos.recording import published_fields
from tiloilc.evaluate.optimum import task_optimum
from tiloilc.label import Labeller, compile_predicates
from tiloilc.ltl import parse
from tiloilc.product import Copies
from tiloilc.spec import Spec, read_spec
from tiloilc.tasks import Expert, experts_of

every_spec = pytest.mark.parametrize("name", SPECS)


def task(root: Path, name: str) -> tuple[Spec, Labeller, Ldba]:
    spec = read_spec(root / "specs" / f"{name}.yaml").spec
    fields = published_fields(spec.environment.id, spec.environment.kwargs)
    labels = compile_predicates({n: str(p) for n, p in spec.propositions.items()}, fields)
    names = tuple(spec.propositions)
    return spec, labels, translate(parse(str(spec.formula), names).formula, names)


@every_spec
def test_predicates_say_what_is_meant(name: str, root: Path) -> None:
    spec, labels, _ = task(root, name)
    seen = states(name, 10_000)
    letters = labels(seen)
    np.testing.assert_array_equal(letters, by_hand(name, seen))
    for i in range(len(spec.propositions)):
        assert 0.02 < (letters >> i & 1).mean() < 0.98, "each is true and false"


@every_spec
def test_nothing_is_reached_at_the_beginning(name: str, root: Path) -> None:
    _, labels, _ = task(root, name)
    env = make(IDS[name])
    letters = labels(np.array([env.reset(seed=s)[0] for s in range(50)]))
    assert set(letters.tolist()) <= ({0, 1} if name == "fetchplace_tray" else {0})


@every_spec
def test_bundled_demonstrations_are_accepted(name: str, root: Path) -> None:
    spec, labels, ldba = task(root, name)
    demos = bundled(name)
    assert demos is not None
    assert len(demos) == 5
    assert demos.has_actions
    assert demos.meta["environment"]["horizon"] == spec.environment.horizon
    assert set(demos.meta["versions"]) == {"gymnasium", "mujoco", "numpy", "tiloilc"}
    for demo in demos.episodes:
        run = replay(demo.observations, labels, ldba)
        assert run.violates_at is None
        assert run.visits == 2 if name == "fetchplace_button" else run.visits >= 1
    if name == "fetchplace_tray":
        assert {bool(demo.observations[0, 27]) for demo in demos.episodes} == {True, False}


@every_spec
def test_bundled_actions_make_the_demonstrations_again(name: str) -> None:
    """Up to the last digits, in which processors differ."""
    demos = bundled(name)
    assert demos is not None
    env = make(IDS[name])
    for seed, demo in list(zip(demos.meta["seeds"], demos.episodes, strict=True))[:2]:
        assert demo.actions is not None
        seen = [env.reset(seed=seed)[0]] + [env.step(action)[0] for action in demo.actions]
        np.testing.assert_allclose(np.array(seen), demo.observations, rtol=0, atol=2e-3)


def test_recording_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    for file in ("one.npz", "two.npz"):
        save(tmp_path / file, record("tiloilc/FetchPlaceButton-v0", horizon=500, count=2))
    for end in ("npz", "json"):
        one, two = (tmp_path / f"{file}.{end}" for file in ("one", "two"))
        assert one.read_bytes() == two.read_bytes()


def attempt(name: str, labels: Labeller, ldba: Ldba, seed: int, noise: float) -> tuple[int, int]:
    """An episode of the expert: accepting visits, and whether it violated."""
    env = make(IDS[name])
    expert: Expert = dataclasses.replace(experts_of(env)[0], noise=noise)
    generator = np.random.default_rng(seed)
    seen = [env.reset(seed=seed)[0]]
    progress = expert.begin(seen[0], generator)
    for _ in range(120):
        action, progress = expert.act(seen[-1], progress, generator)
        if progress.done:
            break
        assert env.action_space.contains(action)
        seen.append(env.step(action)[0])
    run = ldba.run(labels(np.array(seen)).tolist())
    return sum(b in ldba.accepting for b in run[1:]), ldba.sink in run


@every_spec
def test_an_expert_reaches_acceptance(name: str, root: Path) -> None:
    _, labels, ldba = task(root, name)
    for seed, noise in ((100, 0.0), (101, 0.2)):
        visits, violated = attempt(name, labels, ldba, seed, noise)
        assert visits >= 1
        assert not violated
        if name == "fetchplace_button":
            assert visits == 2, "an expert on a cycle stops after two rounds"


@pytest.mark.slow
@every_spec
def test_an_expert_reaches_acceptance_in_nine_of_ten_episodes(name: str, root: Path) -> None:
    _, labels, ldba = task(root, name)
    for noise in (0.0, 0.2):
        runs = [attempt(name, labels, ldba, seed, noise) for seed in range(50)]
        assert sum(visits >= 1 and not violated for visits, violated in runs) >= 45


def test_copies_stepped_together_are_single_environments(root: Path) -> None:
    environment = read_spec(root / "specs" / "fetch_align.yaml").spec.environment
    copies, actions = Copies(environment, 4), np.stack([moves(15, seed=s) for s in range(4)])
    seen = [copies.reset([5, 6, 7, 8], np.ones(4, np.bool_))]
    seen += [copies.step(actions[:, t])[0] for t in range(15)]
    copies.close()
    for i in range(4):
        alone = rollout(make("FetchAlign"), actions[i], seed=5 + i)
        np.testing.assert_array_equal(np.array(seen)[:, i], alone)


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [("fetch_avoid", 38, 43), ("fetch_align", 32, 50), ("fetchplace_button", 30, 250)],
)
def test_the_best_that_is_known_is_told(name: str, least: float, most: float, root: Path) -> None:
    spec, labels, ldba = task(root, name)
    world = spec.environment
    best = task_optimum(world.id, world.kwargs, labels, ldba, world.horizon)
    assert best is not None
    assert least <= best.accepting_visits <= most
    assert not best.exact
    assert "a lower bound, reached by real actions" in best.how
