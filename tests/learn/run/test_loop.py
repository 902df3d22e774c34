"""Collecting: what is stored of each step, when episodes end, who learns how often."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from tests.learn.examples import beyond, cell_is, settings
from tests.plan.automata import chain, ring, stabilization
from tests.product import worlds  # noqa: F401  # registers
from tiloilc.automaton.ldba import Ldba
from tiloilc.learn.engine.state import State
from tiloilc.learn.run.loop import Loop
from tiloilc.learn.run.tally import Tally
from tiloilc.plan import stage_plan
from tiloilc.product import Copies, Floats, Int, Segmenter, walk_tables
from tiloilc.spec.model import Environment


class Spy:
    """An agent that goes right, takes the last option, and notes everything."""

    def __init__(self, action: Any = 2) -> None:
        self.action = action
        self.steps: list[dict[str, NDArray[Any]]] = []
        self.segments: list[tuple[int, int, list[Any]]] = []
        self.ended: list[tuple[list[Any], list[Any]]] = []
        self.explored = self.acted = self.begun = 0
        self.progress: list[float] = []
        self.inferred: list[tuple[int, bool]] = []

    def explore(self, rng: np.random.Generator, shape: tuple[int, int]) -> NDArray[Any]:
        self.explored += 1
        return self._actions(shape)

    def act(self, observations: Floats, states: Int, greedy: bool) -> NDArray[Any]:
        assert not greedy
        assert observations.shape[:2] == states.shape
        self.acted += 1
        return self._actions(states.shape)

    def _actions(self, shape: Sequence[int]) -> NDArray[Any]:
        if isinstance(self.action, int):
            return np.full(shape, self.action)
        return np.broadcast_to(np.array(self.action, np.float32), (*shape, 1)).copy()

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        assert not greedy
        return options[..., -1]

    def record(self, *columns: NDArray[Any]) -> None:
        names = ("observation", "action", "after", "state", "letter", "terminal", "arrived")
        self.steps.append({n: np.array(c) for n, c in zip(names, columns, strict=True)})

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        self.segments.append((seed, buffer, observations[:, 0].tolist()))

    def finish(self, over: NDArray[np.bool_], length: Int) -> None:
        self.ended.append((over[:, 0].tolist(), length[:, 0].tolist()))

    def begin(self) -> bool:
        self.begun += 1
        return False

    def infer(self, cloning: bool) -> None:
        self.inferred.append((len(self.steps), cloning))

    def learn(self, progress: float) -> dict[str, Tensor]:
        self.progress.append(progress)
        return {"loss": torch.ones(2)}

    def policy(self) -> State:
        return {}

    def load_policy(self, state: State) -> None:
        pass

    def state(self) -> State:
        return {}

    def load(self, state: State) -> None:
        pass


def looped(
    ldba: Ldba,
    labels: Any,
    until: int,
    horizon: int = 5,
    copies: int = 1,
    world: str = "TestsLine-v0",
    action: Any = 2,
    kwargs: dict[str, Any] | None = None,
    **changes: object,
) -> tuple[Loop, Spy]:
    """A loop of two seeds, run up to `until`."""
    given = settings(**{"learning_starts": 2, **changes})
    walk = walk_tables(ldba, given.epsilon)
    many = Copies(Environment(id=world, horizon=horizon, kwargs=kwargs or {}), 2 * copies)
    collector = Segmenter(walk, stage_plan(ldba), many.count, horizon, many.dimensions, True)
    spy = Spy(action)
    loop = Loop(given, horizon, walk, many, labels, spy, collector)
    for _ in loop.run(until):
        pass
    return loop, spy


def column(spy: Spy, name: str, seed: int = 0) -> list[Any]:
    return [step[name][seed, 0].reshape(-1)[0].item() for step in spy.steps]


CHAIN, AT = chain(["zero", "three"]), cell_is(0, 3)


def test_a_step_is_stored_with_the_state_before_it_and_the_letter_after_it() -> None:
    _, spy = looped(CHAIN, AT, until=4)
    assert column(spy, "observation") == [0, 1, 2, 3]
    assert column(spy, "after") == [1, 2, 3, 4]
    assert column(spy, "state") == [1, 1, 1, 2]  # the first label was read; b, not b'
    assert column(spy, "letter") == [0, 0, 2, 0]  # of s', not of s
    assert column(spy, "action") == [2, 2, 2, 2]


def test_the_time_limit_is_not_terminal() -> None:
    _, spy = looped(CHAIN, AT, until=12, horizon=5)
    assert not any(column(spy, "terminal"))
    assert spy.ended == [([True, True], [5, 5])] * 2


def test_an_environments_own_end_is_terminal() -> None:
    _, spy = looped(CHAIN, AT, until=8, horizon=5, kwargs={"size": 4, "ends": True})
    assert column(spy, "terminal") == [False, False, True] * 2 + [False, False]
    assert spy.ended == [([True, True], [3, 3])] * 2


def test_an_episode_has_horizon_steps() -> None:
    _, spy = looped(CHAIN, AT, until=11, horizon=5, kwargs={"size": 100})
    assert column(spy, "observation") == [0, 1, 2, 3, 4] * 2 + [0]
    assert column(spy, "after") == [1, 2, 3, 4, 5] * 2 + [1]


def test_no_transition_crosses_a_reset() -> None:
    _, spy = looped(CHAIN, AT, until=40, horizon=5, kwargs={"size": 100, "start": None})
    for seed in range(2):
        before, after = column(spy, "observation", seed), column(spy, "after", seed)
        assert all(a == b + 1 or b == 99 for b, a in zip(before, after, strict=True))
        jumps = [t for t in range(1, 40) if before[t] != after[t - 1]]
        assert set(jumps) <= set(range(5, 40, 5))
        assert len(jumps) > 3


def test_an_episode_stops_in_a_sink_if_told_so() -> None:
    deadly = ring(["far"], "two"), cell_is(7, 2)
    _, stops = looped(*deadly, until=4, horizon=5, end_on_sink=True)
    assert column(stops, "observation") == [0, 1, 0, 1]
    assert not any(column(stops, "terminal"))  # the sink's value says it, not an end
    _, goes_on = looped(*deadly, until=6, horizon=5, end_on_sink=False)
    assert column(goes_on, "observation") == [0, 1, 2, 3, 4, 0]
    assert column(goes_on, "state") == [0, 0, 2, 2, 2, 0]


def test_segments_of_episodes_reach_the_agent_with_both_their_ends() -> None:
    _, spy = looped(CHAIN, AT, until=10, horizon=5, kwargs={"size": 100})
    mine = [(b, seen) for seed, b, seen in spy.segments if seed == 0]
    assert mine == [(2, [0, 1, 2, 3])] * 2  # up to the visit; the stay is no segment


def test_the_fatal_state_is_in_the_sink_buffer() -> None:
    deadly = ring(["far"], "two"), cell_is(7, 2)
    _, spy = looped(*deadly, until=2, horizon=5, end_on_sink=True)
    assert spy.segments == [(0, 3, [0, 1, 2]), (1, 3, [0, 1, 2])]


def test_nobody_jumps_into_a_sink_while_exploring() -> None:
    """The spy takes every jump that it is offered; alive it stays as long as yellow holds."""
    yellow_then_none = cell_is(9, 8)
    _, spy = looped(stabilization(), yellow_then_none, until=5, learning_starts=100)
    assert column(spy, "state") == [0] * 5
    _, spy = looped(stabilization(), cell_is(2, 8), until=4, end_on_sink=False)
    assert column(spy, "state") == [0, 0, 1, 2]  # it promised yellow in cell 2, and left it


def test_actions_are_random_until_learning_starts() -> None:
    _, spy = looped(CHAIN, AT, until=10, learning_starts=4)
    assert (spy.explored, spy.acted, spy.begun) == (4, 6, 1)
    assert spy.progress == [1, 2, 3, 4, 5, 6]


def test_actions_are_inferred_again_whenever_the_steps_have_grown_by_a_factor() -> None:
    growing = {"learning_starts": 4, "inference_growth": 2, "warm_start_steps": 10}
    _, spy = looped(CHAIN, AT, until=40, **growing)
    assert spy.inferred == [(8, True), (16, False), (32, False)]  # cloned up to step 14
    _, spy = looped(CHAIN, AT, until=40, learning_starts=4)
    assert spy.inferred == []
    _, spy = looped(CHAIN, AT, until=40, learning_starts=0, inference_growth=2)
    assert spy.inferred == []


def test_learning_may_start_at_once() -> None:
    _, spy = looped(CHAIN, AT, until=3, learning_starts=0)
    assert (spy.explored, spy.acted, spy.begun) == (0, 3, 1)
    assert spy.progress == [1, 2, 3]


@pytest.mark.parametrize("copies", [1, 2, 5])
@pytest.mark.parametrize(("rate", "updates"), [(1.0, 100), (0.25, 25), (2.0, 200), (0.3, 30)])
def test_updates_per_step_do_not_depend_on_copies(copies: int, rate: float, updates: int) -> None:
    loop, spy = looped(
        CHAIN, AT, until=110, copies=copies, learning_starts=10, updates_per_step=rate
    )
    assert loop.step == 110
    assert spy.acted == 100 / copies
    assert abs(len(spy.progress) - updates) <= 1


def test_copies_belong_to_their_seeds() -> None:
    _, spy = looped(
        CHAIN, AT, until=3, copies=3, learning_starts=0, kwargs={"size": 10**6, "start": None}
    )
    (step,) = spy.steps
    assert step["observation"].shape == (2, 3, 1)
    assert step["state"].shape == (2, 3)
    assert len(np.unique(step["observation"])) == 6  # every copy starts elsewhere


def test_environment_seeds_differ_between_agents_copies_and_episodes() -> None:
    loop, _ = looped(CHAIN, AT, until=0, copies=3)
    everyone = np.ones(6, np.bool_)
    seeds = [seed for n in range(200) for seed in loop._seeds(np.full(6, n), everyone)]
    assert len(set(seeds)) == 1200
    assert all(0 <= seed < 2**32 for seed in seeds)
    other, _ = looped(CHAIN, AT, until=0, copies=3, first_seed=50)
    first = np.zeros(6, np.int64)
    assert not set(other._seeds(first, everyone)) & set(seeds)
    some = np.arange(6) % 2 == 1
    assert loop._seeds(first, some) == [0, seeds[1], 0, seeds[3], 0, seeds[5]]


def test_agents_see_different_starts_in_every_episode() -> None:
    _, spy = looped(CHAIN, AT, until=50, horizon=5, kwargs={"size": 10**6, "start": None})
    starts = [column(spy, "observation", seed)[::5] for seed in range(2)]
    assert len({*starts[0], *starts[1]}) == 20


def test_global_randomness_plays_no_part() -> None:
    found = []
    for seed in (1, 2):
        np.random.seed(seed)  # noqa: NPY002  # the point of the test
        torch.manual_seed(seed)
        _, spy = looped(
            stabilization(),
            beyond(0.4, 1.5),
            until=20,
            world="TestsDrift-v0",
            action=[0.5],
        )
        found.append(np.stack([step["after"] for step in spy.steps]))
    assert np.array_equal(*found)


def test_the_tally_counts_arrivals_and_ended_episodes() -> None:
    loop, _ = looped(CHAIN, AT, until=7, horizon=5, kwargs={"size": 100})
    tally = loop.tally
    assert tally.visits.tolist() == [3, 3]  # at cells 3, 4, 5; the first state is no arrival
    assert tally.episodes.tolist() == [1, 1]
    assert tally.violations.tolist() == [0, 0]
    assert tally.occupancy.tolist() == [[0, 4, 3]] * 2
    assert tally.event() == {
        "visits": [3.0, 3.0],
        "violations": [0.0, 0.0],
        "stage_histogram": [[0, 4, 3]] * 2,
        "losses": {"loss": [1.0, 1.0]},
    }


def test_a_violation_is_counted_once_an_episode() -> None:
    deadly = ring(["far"], "two"), cell_is(7, 2)
    for ends in (True, False):
        loop, _ = looped(*deadly, until=10, horizon=5, end_on_sink=ends)
        ended = 5 if ends else 2
        assert loop.tally.episodes.tolist() == [ended] * 2
        assert loop.tally.violations.tolist() == [ended] * 2


def test_nothing_is_claimed_before_an_episode_has_ended() -> None:
    loop, _ = looped(CHAIN, AT, until=2, horizon=5)
    assert loop.tally.event()["visits"] == [None, None]


def test_losses_are_means_over_the_updates_that_had_any() -> None:
    """Methods that judge whole episodes learn nothing between their ends."""
    tally = Tally.empty(1, 2)
    for losses in ({}, {"change": torch.tensor([4.0])}, {}, {"change": torch.tensor([2.0])}):
        tally.add_losses(losses)
    assert tally.event()["losses"] == {"change": [3.0]}


# jumps that take a step


def test_a_jump_that_takes_a_step_shortens_the_episode_and_is_no_transition() -> None:
    """The promise of yellow is made in cell 0 and broken in cell 1, by the third step of five."""
    _, spy = looped(stabilization(), cell_is(8, 9), until=3, horizon=5, epsilon="step")
    assert column(spy, "observation") == [0, 0, 0]
    assert column(spy, "state") == [1, 1, 1]  # where the jump led
    assert column(spy, "after") == [1, 1, 1]  # no step in which the environment stands still
    assert spy.ended == [([True, True], [1, 1])] * 3


def test_the_segment_before_a_jump_ends_in_the_state_that_it_leads_to() -> None:
    _, spy = looped(
        stabilization(), cell_is(8, 9), until=2, horizon=5, epsilon="step", end_on_sink=False
    )
    mine = [(b, seen) for seed, b, seen in spy.segments if seed == 0]
    assert mine == [(1, [0, 0])]  # (s, 0) and, a step later, (s, 1), which accepts


def test_an_episode_has_horizon_steps_jumps_included() -> None:
    always_yellow = cell_is(0, 9)
    loop, spy = looped(
        stabilization(), always_yellow, until=12, horizon=5, epsilon="step", action=1
    )
    assert [lengths for over, lengths in spy.ended] == [[4, 4]] * 3
    visits = 3 * (1 + 4) + 1  # the jumps' arrivals, four of yellow each; the fourth has begun
    assert loop.tally.event()["visits"] == [visits / 3] * 2


# resuming


@pytest.mark.parametrize("at", range(1, 14))
@pytest.mark.parametrize("epsilon", ["free", "step"])
def test_a_loop_goes_on_from_its_state_at_any_step(at: int, epsilon: str) -> None:
    """Seeds die at different times, so episodes are at different steps when the state is taken."""
    deadly = ring(["far"], "deadly"), beyond(9, 0.3)
    if epsilon == "step":
        deadly = stabilization(), beyond(-1, 0.3)  # a jump at once, and then yellow for ever

    def build(until: int) -> tuple[Loop, Spy]:
        drift = {"world": "TestsDrift-v0", "action": [0.6], "horizon": 6}
        return looped(*deadly, until=until, epsilon=epsilon, **drift)

    whole, expected = build(20)
    first, _ = build(at)
    second, spy = build(0)
    second.load({name: tensor.clone() for name, tensor in first.state().items()})
    spy.segments.clear()  # of its own first jump
    for _ in second.run(20):
        pass
    assert len(spy.steps) == 20 - at
    for mine, theirs in zip(spy.steps, expected.steps[at:], strict=True):
        for name, array in mine.items():
            assert np.array_equal(array, theirs[name]), name
    assert second.tally.event() == whole.tally.event()
    assert spy.segments == expected.segments[len(expected.segments) - len(spy.segments) :]


def test_copies_of_that_test_are_at_different_steps_some_of_the_time() -> None:
    deadly = ring(["far"], "deadly"), beyond(9, 0.3)
    elapsed = []
    for until in range(1, 14):
        loop, _ = looped(*deadly, until=until, world="TestsDrift-v0", action=[0.6], horizon=6)
        elapsed.append(tuple(loop.product.elapsed.tolist()))
    assert any(first != second for first, second in elapsed), elapsed


def test_resuming_steps_no_environment_past_its_end() -> None:
    """`Line` refuses to be stepped once it has ended."""

    def build(until: int) -> Loop:
        return looped(
            CHAIN, AT, until=until, horizon=50, kwargs={"size": 9, "start": None, "ends": True}
        )[0]

    for at in range(1, 12):
        second = build(0)
        second.load({name: tensor.clone() for name, tensor in build(at).state().items()})
        assert second.step == at
