"""Tabular TiLoIL against exact solutions of Eq. 4 on small products."""

from collections.abc import Sequence
from importlib.metadata import EntryPoint
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete, MultiBinary, MultiDiscrete

from tests.learn.exact import GAMMA, MOST, RING, RISKY, SIZE, STAY, exact, labels_of, swept, task
from tests.learn.examples import demos, generator, nothing_shown, settings
from tiloilc.learn import make_loop
from tiloilc.learn.agent.tabular import TabularAgent
from tiloilc.learn.algorithm import Backup, Plain
from tiloilc.learn.algorithm.tiloil import StageTable, stage_reward
from tiloilc.learn.engine.replay import Batch
from tiloilc.plan import stage_plan
from tiloilc.product import walk_tables


@pytest.mark.parametrize("kind", ["constant", "live"])
def test_relabelled_steps_have_the_same_fixed_point(kind: str) -> None:
    """Each step teaches every live state: the letters do not depend on where the agent was."""
    for ldba in (RING, RISKY, STAY):
        made = task(ldba, relabel=True, accepting_target=kind, exact_entry=True)
        live = [b for b in ldba.states if b != ldba.sink]
        found = swept(made).q[0].numpy()
        assert np.allclose(found[:, live], exact(made)[:, live], atol=1e-3)


def test_an_optimistic_table_comes_down_to_the_same_fixed_point() -> None:
    made = task(RING, optimistic=True)
    assert np.allclose(swept(made).q[0].numpy(), exact(made), atol=1e-3)


def test_segment_makes_acceptance_the_beginning_of_the_next_segment() -> None:
    """The accepting state of a ring shares the row of its first state: same Q, same acts."""
    made = task(RING, accepting_target="segment", exact_entry=True)
    agent = swept(made)
    assert agent.code.tolist() == [0, 1, 0, 3]
    expected = exact(task(RING, exact_entry=True))  # outside acceptance nothing changes
    assert np.allclose(agent.q[0, :, :2].numpy(), expected[:, :2], atol=1e-3)
    seen = np.arange(SIZE, dtype=np.float32)[None, :, None]
    acts = [agent.act(seen, np.full((1, SIZE), b), greedy=True).tolist() for b in (0, 2)]
    assert acts[0] == acts[1]


def test_demonstrated_values_are_lower_bounds_of_the_exact_ones() -> None:
    path = [1.0, 2, 3, 4, 3, 2, 1, 0, 1, 1, 2]
    for ldba, epsilon in ((RING, "free"), (STAY, "free"), (STAY, "step"), (RISKY, "free")):
        for kind in ("constant", "live"):
            for entry in (False, True):
                made = task(
                    ldba,
                    epsilon=epsilon,
                    accepting_target=kind,
                    exact_entry=entry,
                    demo_replay=0.5,
                    beta=0.3,
                )
                agent = make_loop(made, demos(path, path[4:]), labels_of(ldba)).agent
                assert isinstance(agent, TabularAgent)
                floor, values = agent.floor.numpy(), exact(made).max(-1)
                assert (floor <= values + 1e-4).all()
                if entry and ldba is not STAY:
                    assert np.isfinite(floor).any()


def test_a_demonstration_raises_what_is_known_of_its_states() -> None:
    """One step from acceptance, and two: Eq. 4 with the least reward, by hand."""
    made = task(RING, exact_entry=True, demo_replay=0.5, beta=0.3)
    agent = make_loop(made, demos([2, 1, 0]), labels_of(RING)).agent
    near = (1 - 0.3) / 2 + GAMMA * MOST  # b = 1 waits for `left`; SIDX 1 of 2, tanh f ≥ -1
    assert agent.floor[1, 1].item() == pytest.approx(near)
    assert agent.floor[2, 1].item() == pytest.approx((1 - 0.3) / 2 + GAMMA * near)
    assert agent.floor[0].tolist() == [-np.inf] * 4  # the last state has no step
    assert agent.floor[3].tolist() == [-np.inf] * 4  # never shown


def test_values_on_demonstrated_paths_are_never_below_the_floor() -> None:
    made = task(RING, exact_entry=True, demo_replay=0.5)
    with_floor = swept(made, demos([3, 4, 3, 2, 1, 0]), sweeps=1).q[0]
    without = swept(task(RING, exact_entry=True), sweeps=1).q[0]
    assert (with_floor >= without - 1e-6).all()
    assert (with_floor > without + 1).any()


def test_without_demo_replay_there_is_no_floor() -> None:
    agent = make_loop(task(RING), demos([3, 4, 3, 2, 1, 0]), labels_of(RING)).agent
    assert (agent.floor == -np.inf).all()


class Arrivals(Plain):
    """Pays 1 for each arrival in acceptance."""

    def backup(self, batch: Batch, options: torch.Tensor) -> Backup:
        paid = torch.from_numpy(self.walk.accepting)[options].float()
        return Backup(paid, torch.tensor(self.settings.gamma))


def test_an_algorithm_of_ones_own_learns_on_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """A round of the ring is four steps to the right and four to the left, paid with the last."""
    entry = EntryPoint("arrivals", f"{__name__}:Arrivals", "tiloilc.algorithms")
    monkeypatch.setattr("tiloilc.learn.algorithm.method._registered", lambda name: entry)
    monkeypatch.setattr(EntryPoint, "load", lambda self: Arrivals)
    found = swept(task(RING, algorithm="arrivals")).q[0]
    assert found[0, 2].max().item() == pytest.approx(GAMMA**7 / (1 - GAMMA**8))
    assert found[2, 0].max().item() == pytest.approx(GAMMA**5 / (1 - GAMMA**8))


# what the agent does


def agent(seeds: int = 2, **changes: object) -> TabularAgent:
    """An agent on STAY, without demonstrations."""
    given = settings(seeds=seeds, preset="paper", gamma=GAMMA, **{"entropy": 0.0, **changes})
    space = Box(0, SIZE - 1, (1,), np.int64)
    stages, walk = stage_plan(STAY), walk_tables(STAY)
    return TabularAgent(
        given, stages, walk, space, Discrete(3, start=10), nothing_shown(1), 10, generator()
    )


def test_greedy_actions_are_those_of_greatest_value_in_the_environments_numbers() -> None:
    found = agent()
    found.q[0, 3, 1, 2] = 5
    found.q[1, 3, 1, 1] = 5
    seen, states = np.full((2, 1, 1), 3, np.float32), np.ones((2, 1), np.int64)
    assert found.act(seen, states, greedy=True).tolist() == [[12], [11]]


def test_greedy_decisions_take_no_random_numbers() -> None:
    found = agent()
    before = found.generator.get_state()
    seen = np.zeros((2, 4, 1), np.float32)
    found.act(seen, np.zeros((2, 4), np.int64), greedy=True)
    found.choose(seen, np.tile([0, 1], (2, 4, 1)), greedy=True)
    assert torch.equal(before, found.generator.get_state())


def test_actions_are_drawn_from_the_policy_of_a_temperature() -> None:
    """π ∝ exp(Q / α): with Q = (1, 0, 0) and α = ½ it is (e², 1, 1) / (e² + 2) = (0.787, …)."""
    found = agent(seeds=1, exploration=0.0, entropy=0.5)
    found.q[..., 0] = 1
    seen, states = np.zeros((1, 20_000, 1), np.float32), np.zeros((1, 20_000), np.int64)
    shares = np.bincount(found.act(seen, states, greedy=False)[0] - 10, minlength=3) / 20_000
    assert shares.tolist() == pytest.approx([0.787, 0.1065, 0.1065], abs=0.01)
    assert (found.act(seen, states, greedy=True) == 10).all()


def test_a_tuned_temperature_gives_each_seed_the_wanted_entropy() -> None:
    found = agent(
        entropy="tuned", target_entropy=0.5, critic_rate=0.1, learning_rate=1e-9, optimistic=False
    )
    found.q[0, ..., 0], found.q[1, ..., 0] = 1, 3
    at, moved = np.zeros((2, 1, 1), np.float32), np.array([[10], [10]])
    nowhere = np.zeros((2, 1), np.int64)
    found.record(at, moved, at, nowhere, nowhere, nowhere > 0, nowhere)
    for _ in range(300):
        found.learn(0)
    policy = (found.q[:, 0, 0] / found.alpha[:, None]).softmax(-1)
    assert (-(policy * policy.log()).sum(-1)).tolist() == pytest.approx([0.5, 0.5], abs=0.01)
    assert found.alpha[1] / found.alpha[0] == pytest.approx(3, rel=0.05)
    other = agent(entropy="tuned", target_entropy=0.5)
    other.load_policy(found.policy())
    assert torch.equal(other.alpha, found.alpha)


def test_no_policy_on_a_table_has_a_negative_entropy_so_then_there_is_no_temperature() -> None:
    assert agent(entropy="tuned", target_entropy=-3.0).alpha.tolist() == [0, 0]
    assert agent(entropy=0.3).alpha.tolist() == pytest.approx([0.3, 0.3])


def test_a_share_of_actions_is_random_while_learning() -> None:
    found = agent(seeds=1, exploration=0.3)
    found.q[..., 1] = 5
    seen, states = np.zeros((1, 20_000, 1), np.float32), np.zeros((1, 20_000), np.int64)
    actions = found.act(seen, states, greedy=False) - 10
    shares = np.bincount(actions[0], minlength=3) / actions.size
    assert shares.tolist() == pytest.approx([0.1, 0.8, 0.1], abs=0.02)


def test_ties_are_broken_at_random_while_learning() -> None:
    found = agent(seeds=1, exploration=0.0)
    seen, states = np.zeros((1, 3000, 1), np.float32), np.zeros((1, 3000), np.int64)
    shares = np.bincount(found.act(seen, states, greedy=False)[0] - 10, minlength=3) / 3000
    assert shares.tolist() == pytest.approx([1 / 3] * 3, abs=0.05)


def test_the_option_of_greatest_value_is_chosen() -> None:
    found = agent()
    found.q[0, 4, 0, 2] = 3
    found.q[1, 4, 1, 0] = 3
    seen = np.full((2, 1, 1), 4, np.float32)
    assert found.choose(seen, np.array([[[0, 1]]] * 2), greedy=True).tolist() == [[0], [1]]


def test_an_episode_is_learned_backwards_when_it_ends() -> None:
    """A single pass carries the value of the goal to the first step."""
    found = TabularAgent(
        settings(seeds=1, preset="paper", gamma=GAMMA, learning_rate=1.0, exact_entry=True),
        stage_plan(RING),
        walk_tables(RING),
        Box(0, SIZE - 1, (1,), np.int64),
        Discrete(3),
        nothing_shown(1),
        10,
        generator(),
    )
    for cell in (3, 2, 1):
        found.record(
            np.array([[[cell]]], np.float32),
            np.array([[0]]),
            np.array([[[cell - 1]]], np.float32),
            np.array([[1]]),
            np.array([[2 if cell == 1 else 0]]),
            np.array([[False]]),
            np.array([[1]]),
        )
    found.finish(np.array([[True]]), np.array([[3]]))
    found.learn(0)
    value = GAMMA * MOST
    for cell in (1, 2, 3):
        value = 0.5 + (GAMMA * MOST if cell == 1 else GAMMA * value)
        assert found.q[0, cell, 1, 0].item() == pytest.approx(value)
    assert found.closed == []


def taken(agent: TabularAgent) -> list[list[list[tuple[int, int]]]]:
    """(age, observation) of the steps to be learned, by ended episodes and seed."""
    steps = [(t.age, t.batch.observation[..., 0].long(), t.valid) for t in agent.closed]
    return [
        [
            sorted(zip(age[valid].tolist(), seen[valid].tolist(), strict=True))
            for age, seen, valid in zip(*step, strict=True)
        ]
        for step in steps
    ]


def test_episodes_of_different_lengths_are_learned_each_once() -> None:
    """Seed 0 ends after 2 of 3 steps, seed 1 after 3; no step is learned for the wrong seed."""
    found = agent(seeds=2, learning_rate=1.0)
    for t, ended in enumerate(([False, False], [True, False], [False, True])):
        cells = np.array([[[t]], [[t + 1]]], np.float32)
        zero = np.zeros((2, 1), np.int64)
        found.record(cells, zero + 10, cells, zero, zero, zero.astype(np.bool_), zero)
        length = np.array([[t + 1 if t < 2 else 1], [t + 1]])
        found.finish(np.array(ended)[:, None], length)
    assert taken(found) == [[[(0, 1), (1, 0)], []], [[], [(0, 3), (1, 2), (2, 1)]]]


def test_episodes_that_end_together_have_each_their_own_length() -> None:
    found = agent(seeds=2)
    zero = np.zeros((2, 1), np.int64)
    for t in range(3):
        cells = np.full((2, 1, 1), t, np.float32)
        found.record(cells, zero + 10, cells, zero, zero, zero.astype(np.bool_), zero)
    found.finish(np.array([[True], [True]]), np.array([[1], [3]]))
    assert taken(found) == [[[(0, 2)], [(0, 2), (1, 1), (2, 0)]]]


def test_an_episode_can_be_one_step_of_one_agent() -> None:
    """Arrays of one number are contiguous whatever they are views of; none is written to."""
    found = agent(seeds=1)
    zero = np.zeros((1, 1), np.int64)
    found.record(
        zero[..., None] * 1.0, zero + 10, zero[..., None] * 1.0, zero, zero, zero > 0, zero
    )
    found.finish(zero == 0, zero + 1)
    assert taken(found) == [[[(0, 0)]]]
    found.closed[0].age.add_(1)  # it is the trail's own
    found.finish(zero == 0, zero + 1)
    assert found.closed[1].age.tolist() == [[0]]


def test_more_steps_than_an_episode_has_push_out_the_oldest() -> None:
    """Of 10 at most, in each copy; the last episode begins behind the turn of the ring."""
    found = agent(seeds=1)
    zero = np.zeros((1, 2), np.int64)
    for t in range(13):
        cells = np.array([[[t % SIZE], [(t + 1) % SIZE]]], np.float32)
        found.record(cells, zero + 10, cells, zero, zero, zero.astype(np.bool_), zero)
    found.finish(np.array([[False, True]]), np.array([[9, 4]]))
    assert taken(found) == [[[(0, 13 % SIZE), (1, 12 % SIZE), (2, 11 % SIZE), (3, 10 % SIZE)]]]


def test_each_update_learns_one_copys_latest_step_in_turn() -> None:
    """As many steps are learned as updates are asked for, whatever the number of copies."""
    found = agent(seeds=2, learning_rate=0.5)
    cells = np.array([[[1], [3]], [[1], [3]]], np.float32)
    zero = np.zeros((2, 2), np.int64)
    learned = []
    for _ in range(2):
        found.record(cells, zero + 10, cells, zero, zero, zero == 0, zero)
        for _ in range(3):
            before = found.q.clone()
            found.learn(0)
            learned.append((found.q != before).nonzero()[:, 1].unique().tolist())
    assert learned == [[1], [3], [1], [1], [3], [1]]


def test_seeds_learn_from_their_own_steps_only() -> None:
    found = agent(seeds=2, learning_rate=1.0)
    found.record(
        np.array([[[1]], [[2]]], np.float32),
        np.array([[10], [11]]),
        np.array([[[1]], [[2]]], np.float32),
        np.zeros((2, 1), np.int64),
        np.zeros((2, 1), np.int64),
        np.array([[True], [True]]),
        np.zeros((2, 1), np.int64),
    )
    found.learn(0)
    changed = found.q.nonzero().tolist()
    assert changed == [[0, 1, 0, 0], [1, 2, 0, 1]]  # -γ/(1-γ) each: the environment ended


def test_segments_are_counted_in_their_buffers() -> None:
    found = agent(seeds=2)
    found.segment(1, 3, np.array([[0], [4], [4]], np.float32))
    assert found.method.discriminators.counts[1, 3].tolist() == [1, 0, 0, 0, 2]
    assert found.method.discriminators.counts.sum() == 3


@pytest.mark.parametrize(
    ("space", "observations", "cells"),
    [
        (Discrete(4, start=2), [[2], [5]], [0, 3]),
        (MultiDiscrete([2, 3]), [[0, 0], [1, 2], [1, 0]], [0, 5, 3]),
        (Box(-1, 1, (2,), np.int64), [[-1, -1], [1, 1], [0, 1]], [0, 8, 5]),
        (MultiBinary(3), [[0, 0, 1], [1, 1, 1]], [1, 7]),
    ],
    ids=["discrete", "multi-discrete", "box", "switches"],
)
def test_every_finite_space_is_numbered(
    space: Any, observations: Sequence[Sequence[int]], cells: list[int]
) -> None:
    found = _on(space)
    assert found.cells(np.array(observations)).tolist() == cells
    assert found.q.shape[1] > max(cells)


def _on(space: Any) -> TabularAgent:
    d = int(np.prod(space.shape or (1,)))
    stages, walk = stage_plan(STAY), walk_tables(STAY)
    shown = nothing_shown(d)
    return TabularAgent(settings(), stages, walk, space, Discrete(3), shown, 10, generator())


def test_the_reward_is_that_of_todays_discriminators() -> None:
    """Recomputed at learning, never stored with the step."""
    found = agent(seeds=1, learning_rate=1.0)
    step = [
        np.array([[[1]]], np.float32),
        np.array([[10]]),
        np.array([[[1]]], np.float32),
        np.array([[0]]),
        np.array([[0]]),
        np.array([[False]]),
        np.array([[0]]),
    ]
    found.record(*step)
    found.method.discriminators.values[0, 0, 1] = 0.6  # after the step, before it is learned
    found.learn(0)
    table = StageTable.of(stage_plan(STAY), walk_tables(STAY), found.settings)
    expected = stage_reward(table, torch.tensor([[0]]), torch.tensor(0.6), found.settings)
    assert expected.item() == pytest.approx(0.2)
    assert found.q[0, 1, 0, 0].item() == pytest.approx(0.2)
