"""Episodes for evaluation: who acts, which seeds, what counts once an episode has ended."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.learn.examples import cell_is, plan
from tests.plan.automata import automaton, chain, ring, stabilization
from tiloilc.evaluate.protocol import metrics_of
from tiloilc.evaluate.rollout import Arena, EndlessCopies, Rollout
from tiloilc.product import Floats, Int

RIGHT, STAY, LEFT = 2, 1, 0


class Told:
    """Acts by a rule of (s, b), takes the last option, and notes how it was asked."""

    def __init__(self, rule: Callable[[Floats, Int], NDArray[Any]]) -> None:
        self.rule = rule
        self.greedy: set[bool] = set()

    def act(self, observations: Floats, states: Int, greedy: bool) -> NDArray[Any]:
        assert observations.shape[:2] == states.shape
        self.greedy.add(greedy)
        return self.rule(observations, states)

    def choose(self, observations: Floats, options: Int, greedy: bool) -> Int:
        self.greedy.add(greedy)
        return options[..., -1]

    def policy(self) -> dict[str, Any]:
        raise NotImplementedError

    def load_policy(self, state: dict[str, Any]) -> None:
        raise NotImplementedError


def always(action: int) -> Told:
    return Told(lambda seen, states: np.full(states.shape, action))


def play(made: Any, labels: Any, policy: Told, episodes: int = 2, **how: Any) -> Rollout:
    return Arena(made, labels, episodes).play(policy, range(episodes), **how)


def test_a_rollout_has_the_first_state_and_one_for_each_step_of_the_horizon() -> None:
    made = plan(chain(["zero", "three"]), "TestsLine-v0", horizon=4)
    rollout = play(made, cell_is(0, 3), always(RIGHT))
    assert rollout.observations.tolist() == [[[0], [1], [2], [3], [4]]] * 2  # of each seed
    assert rollout.states.tolist() == [[[1, 1, 1, 2, 2]] * 2] * 2  # the first label was read
    assert rollout.accepting.sum(-1).tolist() == [[2, 2], [2, 2]]
    assert not rollout.sink.any()


def test_the_first_state_is_no_visit_but_enters_the_return() -> None:
    made = plan(chain(["zero"]), "TestsLine-v0", horizon=3)
    metrics = metrics_of(play(made, cell_is(0), always(RIGHT)))
    assert metrics.accepting_visits.tolist() == [3, 3]
    assert metrics.eventual_return.tolist() == pytest.approx([1 + 0.99 + 0.99**2 + 0.99**3] * 2)


def test_eventual_return_discounts_visits_only() -> None:
    """Eq. 17 and 18: on the way, time costs nothing; the k-th visit is worth γ^k."""
    made = plan(ring(["right", "left"], "never"), "TestsLine-v0", horizon=8, kwargs={"size": 3})

    def to_and_fro(seen: Floats, states: Int) -> NDArray[Any]:
        return np.where(states % 2 == 1, LEFT, RIGHT)  # state 1 waits for `left`

    rollout = play(made, cell_is(2, 0, 9), Told(to_and_fro))
    assert rollout.states[0, 0].tolist() == [0, 0, 1, 1, 2, 0, 1, 1, 2]
    metrics = metrics_of(rollout)
    assert metrics.accepting_visits.tolist() == [2, 2]
    assert metrics.eventual_return.tolist() == pytest.approx([1 + 0.99] * 2)
    assert metrics.first_visit.tolist() == [4, 4]
    assert metrics.success.tolist() == [1, 1]
    assert metrics.violation_rate.tolist() == [0, 0]


def test_a_sink_is_a_violation_and_stays_one() -> None:
    made = plan(ring(["far"], "deadly"), "TestsLine-v0", horizon=5, kwargs={"size": 6})
    rollout = play(made, cell_is(5, 2), always(RIGHT))
    assert rollout.sink[0, 0].tolist() == [False, False, True, True, True, True]
    metrics = metrics_of(rollout)
    assert metrics.violation_rate.tolist() == [1, 1]
    assert metrics.accepting_visits.tolist() == [0, 0]


def test_an_episode_that_its_environment_ends_accepts_no_more() -> None:
    made = plan(chain(["end"]), "TestsLine-v0", horizon=6, kwargs={"size": 3, "ends": True})
    rollout = play(made, cell_is(2), always(RIGHT))
    assert rollout.observations[0, :, 0].tolist() == [0, 1, 2, 2, 2, 2, 2]
    assert rollout.states[0, 0].tolist() == [0, 0, 1, 1, 1, 1, 1]
    assert rollout.accepting[0, 0].tolist() == [False, False, True] + [False] * 4
    assert rollout.over[0, 0].tolist() == [False] * 3 + [True] * 4
    assert metrics_of(rollout).accepting_visits.tolist() == [1, 1]


def test_endless_copies_stay_at_the_end_and_their_last_label_is_read_on() -> None:
    line = {"size": 3, "ends": True}
    made = plan(chain(["end"]), "TestsLine-v0", horizon=6, kwargs=line)
    arena = Arena(made, cell_is(2), 2, EndlessCopies)
    by_seed = Told(lambda seen, states: np.broadcast_to([[RIGHT], [STAY]], states.shape))
    for _ in range(2):  # a new episode begins at the start again
        rollout = arena.play(by_seed, range(2))
        assert rollout.observations[..., 0].tolist() == [[0, 1, 2, 2, 2, 2, 2], [0] * 7]
        assert rollout.accepting[0].tolist() == [[False, False] + [True] * 5] * 2
        assert not rollout.accepting[1].any()
        assert not rollout.over.any()
    made = plan(ring(["end"], "never"), "TestsLine-v0", horizon=6, kwargs=line)
    again = Arena(made, cell_is(2, 9), 2, EndlessCopies).play(always(RIGHT), range(2))
    assert again.accepting.sum(axis=2).tolist() == [[5, 5], [5, 5]]  # G F end: for ever


def test_an_episode_that_ended_in_a_sink_stays_a_violation() -> None:
    made = plan(ring(["far"], "end"), "TestsLine-v0", horizon=6, kwargs={"size": 3, "ends": True})
    rollout = play(made, cell_is(7, 2), always(RIGHT))
    assert rollout.sink[0, 0].tolist() == [False, False] + [True] * 5


def test_the_agent_decides_about_jumps_in_evaluation_as_in_training() -> None:
    made = plan(stabilization(), "TestsLine-v0", horizon=2)
    rollout = play(made, cell_is(0, 4), always(STAY))
    assert rollout.states[0, 0].tolist() == [1, 1, 1]  # it takes the jump as soon as it can


def test_a_jump_that_takes_a_step_has_its_place_in_the_rollout() -> None:
    """From cell 0, yellow for ever: the jump, then three moves in a horizon of four."""
    made = plan(stabilization(), "TestsLine-v0", horizon=4, epsilon="step")
    rollout = play(made, cell_is(0, 4), always(STAY))
    assert rollout.states[0, 0].tolist() == [0, 1, 1, 1, 1]
    assert rollout.accepting[0, 0].tolist() == [False, True, True, True, True]
    assert rollout.observations[0, :, 0].tolist() == [0, 0, 0, 0, 0]
    line = {"size": 9, "start": 2}
    made = plan(stabilization(), "TestsLine-v0", horizon=4, epsilon="step", kwargs=line)
    moving = play(made, cell_is(2, 8), always(RIGHT))
    assert moving.observations[0, :, 0].tolist() == [2, 2, 3, 4, 5]
    assert moving.states[0, 0].tolist() == [0, 1, 2, 2, 2]


@pytest.mark.parametrize("greedy", [True, False])
def test_greedy_is_handed_to_the_policy(greedy: bool) -> None:
    made = plan(stabilization(), "TestsLine-v0", horizon=2)
    policy = always(STAY)
    play(made, cell_is(0, 4), policy, greedy=greedy)
    assert policy.greedy == {greedy}


def test_all_seeds_play_the_same_episodes_and_episodes_differ() -> None:
    ldba = automaton(["p"], 1, lambda b, true: 0, {0})
    made = plan(ldba, "TestsLine-v0", horizon=1, kwargs={"start": None, "size": 1000})
    arena = Arena(made, cell_is(0), 3)
    starts = []
    for seeds in (range(3), range(3), range(1, 4)):
        rollout = arena.play(always(STAY), seeds)
        assert np.array_equal(rollout.observations[0], rollout.observations[1])
        starts.append(rollout.observations[0, 0, 0])
    assert starts[0] == starts[1]
    assert starts[0] != starts[2]


def test_each_seed_acts_by_its_own_policy() -> None:
    made = plan(chain(["end"]), "TestsLine-v0", horizon=2, kwargs={"size": 3})
    by_seed = Told(lambda seen, states: np.broadcast_to([[RIGHT], [STAY]], states.shape))
    rollout = play(made, cell_is(2), by_seed)
    assert metrics_of(rollout).success.tolist() == [1, 0]
