from collections.abc import Callable
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

from tests.demos.examples import (
    BLUE,
    BOTH_LOOPS,
    BOTH_LOOPS_PROSE,
    GREEN,
    RED,
    ROAD,
    ROOMS,
    ROOMS_PROSE,
    YELLOW,
    bits,
    chain,
    circular,
    corridor,
    sequential,
    staying,
)
from tiloilc.automaton.ldba import Cube, Edge, Ldba
from tiloilc.demos import (
    Demo,
    DemoSet,
    bundled,
    demonstrations_for,
    expert_names,
    record,
    record_best,
    replay,
    save,
)
from tiloilc.diag import CompileError
from tiloilc.spec.model import Demonstrations, Environment

FLAT = bits(RED, GREEN, YELLOW, BLUE)
CYCLE = chain("rgy", cyclic=True, avoid="b")
THEN_GREEN = Ldba(
    ("r", "g", "y", "b"),
    ("red or yellow", "green", "done", "sink"),
    frozenset({2}),
    3,
    (
        Edge(0, 0, (Cube(13, 0),)),
        Edge(0, 1, (Cube(9, 1), Cube(13, 4))),
        Edge(0, 3, (Cube(8, 8),)),
        Edge(1, 1, (Cube(10, 0),)),
        Edge(1, 2, (Cube(10, 2),)),
        Edge(1, 3, (Cube(8, 8),)),
        Edge(2, 2, (Cube(8, 0),)),
        Edge(2, 3, (Cube(8, 8),)),
        Edge(3, 3, (Cube(0, 0),)),
    ),
)
ROUND = chain("01", cyclic=True, avoid="z")
TASKS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], Ldba, int]] = {
    "carlo": (ROAD, ROUND, 2),
    "flatworld_cycle": (FLAT, CYCLE, 2),
    "flatworld_disjunction": (FLAT, THEN_GREEN, 1),
    "flatworld_stabilization": (bits(YELLOW, BLUE), staying(), 10),
    "sixteen_rooms": (ROOMS, BOTH_LOOPS, 2),
    "sixteen_rooms_prose": (ROOMS_PROSE, BOTH_LOOPS_PROSE, 2),
}
LEVELS = ("easy", "medium", "hard")
for i, level in enumerate(LEVELS):
    avoid = chain("a", cyclic=False, avoid="z")
    TASKS[f"grid_avoid_{level}"] = (corridor((7, 9, 11)[i]), avoid, 1)
    row = chain("abcde"[: i + 3], cyclic=False)
    TASKS[f"grid_sequential_{level}"] = (sequential(i + 3), row, 1)
    round_trip = chain("abcd"[: i + 2], cyclic=True, avoid="z")
    TASKS[f"grid_circular_{level}"] = (circular(i + 2), round_trip, 2)


@pytest.mark.parametrize("name", sorted(TASKS))
def test_bundled_demonstrations_accept_and_never_violate(name: str) -> None:
    labels, ldba, visits = TASKS[name]
    demos = bundled(name)
    assert demos is not None
    assert len(demos) == 5
    assert demos.has_actions
    for demo in demos.episodes:
        run = replay(demo.observations, labels, ldba)
        assert run.violates_at is None
        assert run.visits >= visits
        if visits == 2:
            assert run.visits == 2, "at most two visits on cyclic tasks"


@pytest.mark.parametrize("name", sorted(TASKS))
def test_bundled_demonstrations_are_what_recording_makes(name: str, workdir: Path) -> None:
    demos = bundled(name)
    assert demos is not None
    made = demos.meta["environment"]
    again = record(made["id"], made["kwargs"], horizon=made["horizon"], expert=demos.meta["expert"])
    save("bundled.npz", demos)
    save("again.npz", again)
    assert Path("bundled.npz").read_bytes() == Path("again.npz").read_bytes()
    assert {**demos.meta, "versions": 0} == {**again.meta, "versions": 0}


@pytest.mark.parametrize("name", sorted(TASKS))
def test_bundled_actions_lead_from_each_state_to_the_next(name: str) -> None:
    demos = bundled(name)
    assert demos is not None
    made = demos.meta["environment"]
    env = gym.make(made["id"], **made["kwargs"])
    for seed, demo in zip(demos.meta["seeds"], demos.episodes, strict=True):
        seen = [env.reset(seed=seed)[0]]
        assert demo.actions is not None
        seen += [env.step(action)[0] for action in demo.actions]
        np.testing.assert_array_equal(np.array(seen, np.float32), demo.observations)


def test_both_ways_to_green_are_demonstrated() -> None:
    demos = bundled("flatworld_disjunction")
    assert demos is not None
    by_red = [bool(RED(demo.observations).any()) for demo in demos.episodes]
    assert 0 < sum(by_red) < 5


def test_the_unsafe_set_has_crashes_and_rounds_that_are_not_complete() -> None:
    demos = bundled("carlo_unsafe")
    assert demos is not None
    again = record("tiloilc/Carlo-v0", horizon=500, expert="unsafe")
    runs = [replay(demo.observations, ROAD, ROUND) for demo in demos.episodes]
    assert [run.visits for run in runs] == [0] * 5
    assert sorted(run.violates_at is None for run in runs) == [False] * 3 + [True] * 2
    for ours, made in zip(demos.episodes, again.episodes, strict=True):
        np.testing.assert_array_equal(ours.observations, made.observations)


@pytest.mark.parametrize(("steps", "visits"), [(100, 0), (200, 0), (400, 2)])
def test_carlos_demonstrations_can_be_cut_to_the_lengths_of_table_4(
    steps: int, visits: int, workdir: Path
) -> None:
    road = Environment(id="tiloilc/Carlo-v0", horizon=500)
    demos = demonstrations_for(
        asked(count=5, max_steps=steps), road, ROAD, ROUND, name="carlo", folder=workdir
    )
    assert max(demo.steps for demo in demos.episodes) == steps
    best = max(replay(demo.observations, ROAD, ROUND).visits for demo in demos.episodes)
    assert best == visits


def test_more_demonstrations_than_are_bundled_begin_with_the_bundled_ones(workdir: Path) -> None:
    road = Environment(id="tiloilc/Carlo-v0", horizon=500)
    more = demonstrations_for(asked(count=10), road, ROAD, ROUND, name="carlo", folder=workdir)
    ours = bundled("carlo")
    assert ours is not None
    assert len(more) == 10
    for mine, made in zip(ours.episodes, more.episodes[:5], strict=True):
        np.testing.assert_array_equal(mine.observations, made.observations)


def test_the_sidecar_says_what_was_recorded() -> None:
    demos = record("tiloilc/FlatWorld-v0", {"dt": 0.3}, horizon=20, expert="cycle", count=2, seed=7)
    assert demos.meta["environment"] == {
        "id": "tiloilc/FlatWorld-v0",
        "kwargs": {"dt": 0.3},
        "horizon": 20,
    }
    assert demos.meta["expert"] == "cycle"
    assert demos.meta["fields"] == {"pos": [0, 2]}
    assert demos.meta["seeds"] == [7, 8]
    assert set(demos.meta["versions"]) == {"gymnasium", "numpy", "tiloilc"}


def test_other_seeds_give_other_demonstrations() -> None:
    one, two = (
        record("tiloilc/FlatWorld-v0", horizon=50, expert="cycle", count=1, seed=s) for s in (0, 1)
    )
    assert one.episodes[0].observations.tobytes() != two.episodes[0].observations.tobytes()


def test_an_unknown_expert_is_a_finding_that_names_the_known() -> None:
    with pytest.raises(CompileError) as raised:
        record("tiloilc/FlatWorld-v0", horizon=5, expert="nobody")
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.code == "DEMO506"
    assert diagnostic.message == ("there is no scripted expert `nobody` for `tiloilc/FlatWorld-v0`")
    assert diagnostic.help == "its experts: stabilization, cycle, disjunction"


def test_a_slip_in_the_name_of_an_expert_is_corrected() -> None:
    with pytest.raises(CompileError) as raised:
        record("tiloilc/FlatWorld-v0", horizon=5, expert="cycel")
    (diagnostic,) = raised.value.diagnostics
    listed = "its experts: stabilization, cycle, disjunction"
    assert diagnostic.help == f"did you mean `cycle`? {listed}"


def test_an_environment_without_experts_is_a_finding() -> None:
    assert expert_names("CartPole-v1") == ()
    with pytest.raises(CompileError) as raised:
        record("CartPole-v1", horizon=5)
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.code == "DEMO506"
    assert diagnostic.message == "there is no scripted expert for `CartPole-v1`"


def asked(**more: object) -> Demonstrations:
    return Demonstrations.model_validate({"source": "expert", **more})


FLATWORLD = Environment(id="tiloilc/FlatWorld-v0", horizon=50)


def test_the_expert_of_a_named_task_is_the_bundled_one(workdir: Path) -> None:
    demos = demonstrations_for(
        asked(), FLATWORLD, FLAT, CYCLE, name="flatworld_cycle", folder=workdir
    )
    ours = bundled("flatworld_cycle")
    assert ours is not None
    assert demos.episodes[0].observations.tobytes() == ours.episodes[0].observations.tobytes()
    assert not demos.has_actions, "states only, unless recorded actions are asked for"


@pytest.mark.parametrize(
    ("labels", "ldba", "expert"),
    [
        (FLAT, CYCLE, "cycle"),
        (bits(YELLOW, BLUE), staying(), "stabilization"),
    ],
)
def test_under_another_name_the_expert_that_is_accepted_earliest_is_recorded(
    labels: Callable[[np.ndarray], np.ndarray], ldba: Ldba, expert: str, workdir: Path
) -> None:
    demos = demonstrations_for(
        asked(count=7, actions="recorded"), FLATWORLD, labels, ldba, name="mine", folder=workdir
    )
    assert demos.meta["expert"] == expert
    assert len(demos) == 7
    assert demos.has_actions


def test_of_experts_that_are_all_accepted_the_one_the_task_is_named_after_is_taken() -> None:
    for name in ("cycle", "disjunction"):
        demos = record_best(FLATWORLD, FLAT, THEN_GREEN, name=f"my_{name}", count=3)
        assert demos.meta["expert"] == name


def test_bundled_demonstrations_that_are_not_accepted_are_not_taken(workdir: Path) -> None:
    ours = demonstrations_for(
        asked(), FLATWORLD, FLAT, CYCLE, name="flatworld_stabilization", folder=workdir
    )
    assert ours.meta["expert"] == "cycle", "as someone would see who changed only the formula"


def test_bundled_demonstrations_of_another_variant_are_not_taken(workdir: Path) -> None:
    other = Environment(id="tiloilc/FlatWorld-v0", kwargs={"dt": 0.2}, horizon=90)
    demos = demonstrations_for(asked(), other, FLAT, CYCLE, name="flatworld_cycle", folder=workdir)
    assert demos.meta["environment"]["kwargs"] == {"dt": 0.2}


def test_a_file_is_found_beside_the_task_file(workdir: Path) -> None:
    ours = bundled("flatworld_cycle")
    assert ours is not None
    (workdir / "below").mkdir()
    save(workdir / "below" / "d.npz", ours.without_actions())
    wanted = Demonstrations(file="d.npz", count=3)
    demos = demonstrations_for(wanted, FLATWORLD, FLAT, CYCLE, name="x", folder=workdir / "below")
    assert len(demos) == 3


def test_demonstrations_have_the_number_and_the_length_that_are_wanted(workdir: Path) -> None:
    wanted = Demonstrations(source="expert", count=2, max_steps=7, actions="recorded")
    demos = demonstrations_for(
        wanted, FLATWORLD, FLAT, CYCLE, name="flatworld_cycle", folder=workdir
    )
    assert [demo.steps for demo in demos.episodes] == [7, 7]
    assert [len(demo.actions) for demo in demos.episodes if demo.actions is not None] == [7, 7]
    assert demos.meta["steps"] == [7, 7]


def test_recorded_actions_that_are_not_there_are_a_finding(workdir: Path) -> None:
    ours = bundled("flatworld_cycle")
    assert ours is not None
    save("d.npz", ours.without_actions())
    wanted = Demonstrations(file="d.npz", actions="recorded")
    with pytest.raises(CompileError) as raised:
        demonstrations_for(wanted, FLATWORLD, FLAT, CYCLE, name="x", folder=workdir)
    (found,) = raised.value.diagnostics
    assert (found.code, found.message) == ("DEMO505", "the demonstrations carry no actions")


def test_fewer_demonstrations_than_are_asked_for_are_a_finding(workdir: Path) -> None:
    ours = bundled("flatworld_cycle")
    assert ours is not None
    save(workdir / "d.npz", ours.take(3))

    def taken(wanted: Demonstrations) -> DemoSet:
        return demonstrations_for(wanted, FLATWORLD, FLAT, CYCLE, name="x", folder=workdir)

    with pytest.raises(CompileError, match=r"DEMO511.*`d\.npz` has 3 demonstrations, not 4"):
        taken(Demonstrations(file="d.npz", count=4))
    assert len(taken(Demonstrations(file="d.npz", count=3))) == 3
    assert len(taken(Demonstrations(file="d.npz"))) == 3, "five is not what was asked for"


def test_a_demonstration_without_actions_among_others_is_named(workdir: Path) -> None:
    ours = bundled("flatworld_cycle")
    assert ours is not None
    first, second, *others = ours.episodes
    save(workdir / "d.npz", DemoSet((first, Demo(second.observations), *others)))
    wanted = Demonstrations(file="d.npz", actions="recorded")
    with pytest.raises(CompileError) as raised:
        demonstrations_for(wanted, FLATWORLD, FLAT, CYCLE, name="x", folder=workdir)
    (found,) = raised.value.diagnostics
    assert (found.code, found.message) == ("DEMO505", "demonstration 1 carries no actions")


def test_a_task_file_without_demonstrations_has_none(workdir: Path) -> None:
    none = demonstrations_for(
        Demonstrations(), FLATWORLD, FLAT, CYCLE, name="flatworld_cycle", folder=workdir
    )
    assert len(none) == 0
