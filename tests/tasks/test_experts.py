"""Experts solve their tasks; what they reach is judged by labels and automata made by hand."""

from collections.abc import Callable
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from tests.demos.examples import (
    BLUE,
    GREEN,
    RED,
    ROAD,
    YELLOW,
    bits,
    chain,
    circular,
    corridor,
    rooms,
    sequential,
    staying,
)
from tests.tasks.acting import acted
from tiloilc.automaton.ldba import Ldba
from tiloilc.tasks import Expert, experts_of

FLAT = bits(RED, GREEN, YELLOW, BLUE)
TASKS = [
    (
        "GridAvoid",
        {"distance": d},
        "avoid",
        d + 10,
        corridor(d),
        chain("a", cyclic=False, avoid="z"),
    )
    for d in (7, 9, 11)
]
TASKS += [
    (
        "GridSequential",
        {"zones": k},
        "sequential",
        72,
        sequential(k),
        chain("abcde"[:k], cyclic=False),
    )
    for k in (3, 4, 5)
]
TASKS += [
    (
        "GridCircular",
        {"zones": k},
        "circular",
        horizon,
        circular(k),
        chain("abcd"[:k], cyclic=True, avoid="z"),
    )
    for k, horizon in ((2, 72), (3, 72), (4, 144))
]
TASKS += [
    ("FlatWorld", {"random_start": r}, "cycle", 50, FLAT, chain("rgy", cyclic=True, avoid="b"))
    for r in (False, True)
]
TASKS += [
    ("Carlo", kwargs, "carlo", 500, ROAD, chain("01", cyclic=True, avoid="z"))
    for kwargs in ({}, {"heading": "angle"})
]
TASKS += [
    ("SixteenRooms", {}, name, 300, rooms(loop), chain("abcde"[:k], cyclic=True, avoid="z"))
    for name, loop, k in (
        ("rooms", "31 33 34 44 43", 5),
        ("prose", "33 34 44 43", 4),
        ("large", "12 14 34 32", 4),
    )
]


def named(env: gym.Env, name: str) -> Expert:
    return next(expert for expert in experts_of(env) if expert.name == name)


@pytest.mark.parametrize("noise", [None, 0.0], ids=["own noise", "no noise"])
@pytest.mark.parametrize(("world", "kwargs", "name", "horizon", "labels", "ldba"), TASKS)
def test_an_expert_accepts_and_never_violates_in_fifty_episodes(
    world: str,
    kwargs: dict[str, object],
    name: str,
    horizon: int,
    labels: Callable[[np.ndarray], np.ndarray],
    ldba: Ldba,
    noise: float | None,
) -> None:
    env = gym.make(f"tiloilc/{world}-v0", **kwargs)
    expert = named(env, name)
    if noise is not None:
        expert = replace(expert, noise=noise)
    for seed in range(50):
        run = ldba.run(labels(acted(env, expert, horizon, seed)).tolist())
        assert ldba.sink not in run
        visits = sum(b in ldba.accepting for b in run[1:])
        assert visits >= 1
        if ldba.outgoing[max(ldba.accepting)][0].target != max(ldba.accepting):
            assert visits <= 2, "an expert on a cycle stops after two rounds"


@pytest.mark.parametrize("random_start", [False, True])
def test_the_stabilizing_expert_stays_in_yellow(random_start: bool) -> None:
    env = gym.make("tiloilc/FlatWorld-v0", random_start=random_start)
    ldba, labels = staying(), bits(YELLOW, BLUE)
    for seed in range(50):
        letters = labels(acted(env, named(env, "stabilization"), 50, seed))
        assert len(letters) == 51
        assert not (letters & 2).any()
        inside = (letters & 1).astype(bool)
        first = int(inside.argmax())
        assert inside[first + 5 :].all()
        assert first <= 30
    assert ldba.jumps


def test_the_choosing_expert_takes_both_routes_and_mostly_the_nearer_one() -> None:
    env = gym.make("tiloilc/FlatWorld-v0", random_start=True)
    expert = named(env, "disjunction")
    nearer = taken = 0
    for seed in range(60):
        seen = acted(env, expert, 50, seed)
        letters = FLAT(seen)
        assert not (letters & 8).any()
        first = int(((letters & 5) > 0).argmax())
        assert letters[first] & 5, "red or yellow is visited"
        assert (letters[first + 1 :] & 2).any(), "and green after it"
        red = bool(letters[first] & 1)
        start = seen[0].astype(float)
        to_red = np.hypot(start[0] - 0.45, start[1] + 0.75)
        to_yellow = np.hypot(start[0] + 0.85, start[1] - 0.15)
        nearer += red == (to_red < to_yellow)
        taken += red
    assert 10 <= taken <= 50
    assert nearer >= 45


def test_experts_are_good_but_not_optimal() -> None:
    env = gym.make("tiloilc/GridCircular-v0", zones=4)
    steps = {len(acted(env, named(env, "circular"), 144, seed)) - 1 for seed in range(20)}
    assert min(steps) > 79, "two rounds can be made in 79 steps"
    assert len(steps) > 3


@pytest.mark.parametrize(("speed", "visits"), [((10, 10), 3), ((14, 14), 4), ((25, 25), 7)])
def test_a_driver_who_does_not_stop_makes_more_rounds_the_faster_he_is(
    speed: tuple[float, float], visits: int
) -> None:
    env = gym.make("tiloilc/Carlo-v0")
    ldba = chain("01", cyclic=True, avoid="z")
    driver = replace(named(env, "carlo"), laps=99, speed=speed, noise=0.0)
    run = ldba.run(ROAD(acted(env, driver, 500, 0)).tolist())
    assert ldba.sink not in run
    assert sum(b in ldba.accepting for b in run[1:]) == visits


def test_a_careless_driver_crashes_or_stops_before_a_round_is_complete() -> None:
    env = gym.make("tiloilc/Carlo-v0")
    ldba = chain("01", cyclic=True, avoid="z")
    crashed = 0
    for seed in range(50):
        run = ldba.run(ROAD(acted(env, named(env, "unsafe"), 500, seed)).tolist())
        assert not ldba.accepting & set(run)
        crashed += run[-1] == ldba.sink
        assert run[-1] in (1, ldba.sink)
    assert 15 < crashed < 35


def test_an_environment_without_experts_has_none() -> None:
    assert experts_of(gym.make("CartPole-v1")) == ()


def test_what_cannot_act_is_refused_as_an_expert() -> None:
    class Wrong:
        def experts(self) -> list[object]:
            return [object()]

    with pytest.raises(TypeError, match=r"no begin\(\) and act\(\)"):
        experts_of(Wrong())
