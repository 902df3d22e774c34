import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
from tiloilc.automaton.ldba import Ldba
from tiloilc.evaluate.optimum import Optimum, best_episode, optimum, task_optimum
from tiloilc.tasks import FiniteModel, Known, finite_model

FLAT = bits(RED, GREEN, YELLOW, BLUE)
CYCLE = chain("rgy", cyclic=True, avoid="b")


def best(world: str, kwargs: dict[str, object], labels: object, ldba: Ldba, T: int) -> Optimum:
    found = task_optimum(f"tiloilc/{world}-v0", kwargs, labels, ldba, T)
    assert found is not None
    return found


@pytest.mark.parametrize("distance", [7, 9, 11])
def test_in_the_corridor_eleven_steps_can_accept(distance: int) -> None:
    ldba = chain("a", cyclic=False, avoid="z")
    found = best("GridAvoid", {"distance": distance}, corridor(distance), ldba, distance + 10)
    assert (found.accepting_visits, found.exact) == (11, True)


@pytest.mark.parametrize(("zones", "visits"), [(3, 55), (4, 48), (5, 41)])
def test_in_the_row_all_steps_accept_but_those_of_the_way(zones: int, visits: int) -> None:
    ldba = chain("abcde"[:zones], cyclic=False)
    found = best("GridSequential", {"zones": zones}, sequential(zones), ldba, 72)
    assert found.accepting_visits == visits == 72 - (7 * zones - 3) + 1


@pytest.mark.parametrize(("zones", "horizon", "visits"), [(2, 72, 5), (3, 72, 2), (4, 144, 3)])
def test_around_the_cross_five_two_and_three_visits_can_be_made(
    zones: int, horizon: int, visits: int
) -> None:
    ldba = chain("abcd"[:zones], cyclic=True, avoid="z")
    found = best("GridCircular", {"zones": zones}, circular(zones), ldba, horizon)
    assert (found.accepting_visits, found.exact) == (visits, True)


@pytest.mark.parametrize(("core", "visits"), [(7, 4), (1, 2)])
def test_the_size_of_the_zones_decides_how_many_rounds_fit(core: int, visits: int) -> None:
    model = finite_model(gym.make("tiloilc/GridCircular-v0", zones=4, core=core))
    assert model is not None
    scene = gym.make("tiloilc/GridCircular-v0", zones=4, core=core).unwrapped.scene()
    zones = [s for s in scene.shapes if s.name in "abcd"]
    letters = bits(
        *(
            lambda o, s=s: (o > np.array(s.low)).all(axis=1) & (o < np.array(s.high)).all(axis=1)
            for s in zones
        )
    )(model.observations)
    found = optimum(model, letters, chain("abcd", cyclic=True), 144)
    assert found.accepting_visits == visits


def test_flatworlds_cycle_can_be_made_four_times() -> None:
    found = best("FlatWorld", {}, FLAT, CYCLE, 50)
    assert found.accepting_visits == 4
    assert not found.exact
    assert "lower bound, reached by real actions" in found.how


def test_flatworlds_yellow_can_be_held_for_47_or_48_steps_only_at_dt_04() -> None:
    labels = bits(YELLOW, BLUE)
    assert best("FlatWorld", {}, labels, staying(), 50).accepting_visits == 48
    assert best("FlatWorld", {"dt": 0.1}, labels, staying(), 50).accepting_visits < 47


@pytest.mark.parametrize(
    ("labels", "ldba"), [(FLAT, CYCLE), (bits(YELLOW, BLUE), staying())], ids=["cycle", "stay"]
)
def test_what_the_lattice_promises_real_actions_keep(labels: object, ldba: Ldba) -> None:
    env = gym.make("tiloilc/FlatWorld-v0")
    model = finite_model(env)
    assert model is not None
    letters = labels(model.observations)
    promised = optimum(model, letters, ldba, 50).accepting_visits
    plan = best_episode(model, letters, ldba, 50)
    seen = [env.reset(seed=0)[0]]
    seen += [env.step(model.actions[a])[0] for a in plan.actions]
    real = labels(np.array(seen))
    state = ldba.initial
    for letter, after in zip(real.tolist(), plan.automaton_states.tolist(), strict=True):
        assert after in ldba.options(state, letter)
        state = after
    assert sum(b in ldba.accepting for b in plan.automaton_states[1:].tolist()) == promised


def test_random_starts_are_averaged_over() -> None:
    found = best("FlatWorld", {"random_start": True}, FLAT, CYCLE, 50)
    assert 3.5 < found.accepting_visits < 4, "from some positions only three rounds fit"
    assert "mean over the lattice's free positions" in found.how


@pytest.mark.parametrize(
    ("labels", "ldba", "visits"),
    [(ROOMS, BOTH_LOOPS, 5), (ROOMS_PROSE, BOTH_LOOPS_PROSE, 11)],
    ids=["formula", "prose"],
)
def test_the_small_loop_of_the_text_can_be_made_twice_as_often_as_that_of_the_formula(
    labels: object, ldba: Ldba, visits: int
) -> None:
    found = best("SixteenRooms", {}, labels, ldba, 300)
    assert (found.accepting_visits, found.exact) == (visits, False)
    assert "it takes 6 steps or more from one room's square to the next" in found.how


@pytest.mark.parametrize(("start", "visits"), [(0, 11), (1, 10), (2, 10), (3, 10)])
def test_where_there_is_no_model_the_best_known_episode_counts(start: int, visits: int) -> None:
    ldba = chain("01", cyclic=True, avoid="z")
    found = best("Carlo", {"start": start}, ROAD, ldba, 500)
    assert (found.accepting_visits, found.exact) == (visits, False)
    assert "reached by real actions" in found.how
    assert "13 times to the one region and then to the other" in found.how


def test_jumps_of_known_episodes_are_chosen_as_well_as_they_can_be() -> None:
    seen = np.array([[[0.0], [1.0], [0.0], [1.0], [1.0], [1.0]]])

    class Knowing(gym.Env):
        observation_space = gym.spaces.Box(0, 1, (1,))
        action_space = gym.spaces.Discrete(2)

        def known_best(self, horizon: int) -> tuple[Known, ...]:
            return Known(seen[:, : horizon + 1], "by hand"), Known(0 * seen, "nothing")

    gym.register("Knowing-v0", Knowing)
    try:
        labels = bits(lambda o: o[:, 0] > 0.5, lambda o: o[:, 0] > 2)
        found = task_optimum("Knowing-v0", {}, labels, staying(), 5)
    finally:
        del gym.registry["Knowing-v0"]
    assert found == Optimum(3.0, False, "by hand")


def test_an_environment_that_publishes_nothing_has_no_optimum() -> None:
    assert task_optimum("CartPole-v1", {}, FLAT, CYCLE, 10) is None
    assert task_optimum("tiloilc/Carlo-v0", {"random_start": True}, ROAD, CYCLE, 10) is None


def line(letters: list[int], successor: list[list[int]]) -> FiniteModel:
    n, actions = len(letters), len(successor[0])
    return FiniteModel(
        np.arange(n)[:, None],
        np.array(successor),
        np.array([0]),
        np.arange(actions),
        True,
        "by hand",
    )


def by_search_with_steps(model: FiniteModel, letters: list[int], ldba: Ldba, horizon: int) -> int:
    """The optimum of definition 2.3 by trying everything: moves, and jumps that take a step."""

    def onwards(s: int, b: int, left: int) -> int:
        if left == 0:
            return 0
        moves = [(t, ldba.successor(b, letters[t])) for t in set(model.successor[s].tolist())]
        jumps = [(s, c) for c in ldba.jump_targets[b]]
        return max((c in ldba.accepting) + onwards(t, c, left - 1) for t, c in moves + jumps)

    return onwards(0, ldba.successor(ldba.initial, letters[0]), horizon)


def by_search(model: FiniteModel, letters: list[int], ldba: Ldba, horizon: int) -> int:
    """The optimum by trying everything."""

    def onwards(s: int, b: int, left: int) -> int:
        if left == 0:
            return 0
        return max(
            (after in ldba.accepting) + onwards(t, after, left - 1)
            for t in set(model.successor[s].tolist())
            for after in ldba.options(b, letters[t])
        )

    return max(onwards(0, b, horizon) for b in ldba.options(ldba.initial, letters[0]))


@settings(max_examples=60)
@given(
    letters=st.lists(st.integers(0, 3), min_size=3, max_size=4),
    picks=st.lists(st.integers(0, 11), min_size=8, max_size=8),
    ldba=st.sampled_from([staying(), chain("ab", cyclic=True), chain("a", cyclic=True, avoid="z")]),
    horizon=st.integers(0, 6),
)
def test_the_induction_finds_what_trying_everything_finds(
    letters: list[int], picks: list[int], ldba: Ldba, horizon: int
) -> None:
    n = len(letters)
    model = line(letters, [[picks[2 * s] % n, picks[2 * s + 1] % n] for s in range(n)])
    expected = by_search(model, letters, ldba, horizon)
    assert optimum(model, np.array(letters), ldba, horizon).accepting_visits == expected
    episode = best_episode(model, np.array(letters), ldba, horizon)
    assert sum(b in ldba.accepting for b in episode.automaton_states[1:].tolist()) == expected
    assert len(episode.model_states) == horizon + 1


@settings(max_examples=40)
@given(
    letters=st.lists(st.integers(0, 3), min_size=3, max_size=4),
    picks=st.lists(st.integers(0, 11), min_size=8, max_size=8),
    horizon=st.integers(0, 6),
)
def test_so_it_does_where_jumps_take_a_step(
    letters: list[int], picks: list[int], horizon: int
) -> None:
    n = len(letters)
    model = line(letters, [[picks[2 * s] % n, picks[2 * s + 1] % n] for s in range(n)])
    found = optimum(model, np.array(letters), staying(), horizon, "step").accepting_visits
    assert found == by_search_with_steps(model, letters, staying(), horizon)


def test_the_state_after_the_first_label_is_not_counted() -> None:
    model = line([1], [[0]])
    assert optimum(model, np.array([1]), chain("a", cyclic=False), 3).accepting_visits == 3
    assert optimum(model, np.array([1]), chain("a", cyclic=False), 0).accepting_visits == 0
