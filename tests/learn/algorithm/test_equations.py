"""The paper's equations by hand: each number below can be checked with paper and pencil."""

import math
from collections.abc import Iterator
from itertools import chain as joined
from itertools import combinations

import numpy as np
import pytest
import torch
from torch import tensor

from tests.learn.examples import generator, settings, steps
from tests.plan.automata import disjunction, flatworld_cycle, response, stabilization
from tiloilc.automaton.ldba import Ldba
from tiloilc.evaluate.metrics import eventual_return
from tiloilc.learn.algorithm.tiloil import StageTable, stage_reward, tiloil_backup
from tiloilc.learn.engine.sac import SoftActorCritic
from tiloilc.plan import max_stage, stage_plan
from tiloilc.plan.stages import stage_graph
from tiloilc.product import walk_tables

CYCLE = flatworld_cycle()
"""0 waits for r, 1 for g, 2 for y, 3 accepts, 4 is the sink: SIDX = 0, 1, 2 and N = 3."""


def constant_agent(first: float, second: float) -> SoftActorCritic:
    """One seed, one action; Q₁ = `first` and Q₂ = `second` everywhere, actor's output 0."""
    agent = SoftActorCritic(1, 2, 1, settings(seeds=1, entropy=0.2, layer_norm=False), generator())
    with torch.no_grad():
        for nets in (agent.actor, agent.critics, agent.targets):
            for parameter in nets.parameters:
                parameter.zero_()
        for nets in (agent.critics, agent.targets):
            nets.biases[-1][0], nets.biases[-1][1] = first, second
    return agent


def test_equation_3_is_half_the_mean_squared_distance_to_the_target() -> None:
    """Q₁ = 2, Q₂ = 3, targets 5 and 1, summed over the twins:

    ½ ((2 − 5)² + (2 − 1)²) / 2 = 2.5 and ½ ((3 − 5)² + (3 − 1)²) / 2 = 2, together 4.5.
    """
    loss = constant_agent(2, 3).update_critics(
        torch.zeros(1, 2, 2), torch.zeros(1, 2, 1), tensor([[5.0, 1.0]])
    )
    assert loss.tolist() == pytest.approx([4.5])


def test_equation_4_outside_acceptance_with_its_entropy_term() -> None:
    """R = 0.5, γ = 0.9, min Q_targ = 2, α = 0.2.

    The actor's output 0 means mean 0 and log σ = −5 + 3.5 (tanh 0 + 1) = −1.5; with no noise a = 0,
    log π = −log σ − ½ log 2π = 1.5 − 0.9189385 = 0.5810615, and the tanh has slope 1 there. So
    Q_targ − α log π = 2 − 0.1162123 = 1.8837877 and y = 0.5 + 0.9 · 1.8837877 = 2.1954089.
    """
    agent, given = constant_agent(2, 3), settings(preset="paper", gamma=0.9)
    x = torch.zeros(1, 1, 2)
    value = agent.soft_value(x, agent.sample(x, torch.zeros(1, 1, 1)))
    assert value.item() == pytest.approx(1.8837877, abs=1e-6)
    table = StageTable.of(stage_plan(CYCLE), walk_tables(CYCLE), given)
    step = steps(tensor([[0]]), tensor([[False]]))
    backup = tiloil_backup(table, step, tensor([[[1]]]), tensor([[0.5]]), given)
    y = backup.best(value[..., None])
    assert y.item() == pytest.approx(2.1954089, abs=1e-6)


def test_equation_4_at_acceptance_is_the_sum_of_all_ones() -> None:
    """1 / (1 − 0.99) = 100, whatever the reward and whatever comes."""
    given = settings(preset="paper")
    table = StageTable.of(stage_plan(CYCLE), walk_tables(CYCLE), given)
    one, step = tensor([[7.0]]), steps(tensor([[3]]), tensor([[False]]))
    y = tiloil_backup(table, step, tensor([[[0]]]), one, given).best(one[..., None])
    assert y.item() == pytest.approx(100)


def test_equation_5_is_the_entropy_term_minus_the_lesser_value() -> None:
    """α log π − min Q = 0.2 · 0.5810615 − 2 = −1.8837877, with log π as in equation 4."""
    agent = constant_agent(2, 3)
    x = torch.zeros(1, 4, 2)
    loss = agent.update_actor(x, agent.sample(x, torch.zeros(1, 4, 1)))
    assert loss.tolist() == pytest.approx([-1.8837877])


@pytest.mark.parametrize(
    ("states", "named"),
    [
        ([0, 0, 1, 1], 1),  # r was seen: of 0 and 1, only 1 has a way to 3 that misses the other
        ([0, 1, 2], 2),
        ([0, 1, 2, 3], 3),
        ([0, 1, 4], 5),  # 4 is the sink, and 5 the number of its buffer
    ],
)
def test_equation_7_names_the_stage_that_went_furthest(states: list[int], named: int) -> None:
    assert max_stage(stage_plan(CYCLE), states)[0] == named


def equation_7(ldba: Ldba, visited: set[int]) -> set[int]:
    """All b_i with a path b_i ⇝ b_f that meets no other visited state, by trying every path."""
    follow = stage_graph(ldba)

    def ways(path: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
        if path[-1] in ldba.accepting:
            yield path
            return
        for b in follow[path[-1]]:
            if b not in path:
                yield from ways((*path, b))

    return {b for b in visited for way in ways((b,)) if not visited & set(way[1:])}


@pytest.mark.parametrize("ldba", [CYCLE, disjunction(), response(), stabilization()])
def test_the_stage_that_is_taken_is_one_that_equation_7_names(ldba: Ldba) -> None:
    """Eq. 7 can name several, of which one is taken; of live states it names one at least."""
    live = [b for b in ldba.states if b != ldba.sink]
    subsets = joined.from_iterable(combinations(live, n) for n in range(1, len(live) + 1))
    for visited in subsets:
        assert max_stage(stage_plan(ldba), visited)[0] in equation_7(ldba, set(visited))


def test_equation_8_is_stage_and_discriminator_over_the_longest_way() -> None:
    """SIDX(1) = 1, N(1) = 3, β = 1/3, f = 0.5: tanh 0.5 = 0.4621172, (1 + 0.1540391) / 3."""
    given = settings(preset="paper")
    table = StageTable.of(stage_plan(CYCLE), walk_tables(CYCLE), given)
    reward = stage_reward(table, tensor([[1]]), tensor([[math.tanh(0.5)]]), given)
    assert reward.item() == pytest.approx(0.3846797, abs=1e-7)


def test_equations_17_and_18_discount_at_visits_only() -> None:
    """b = 0, 3, 0, 3, 3 with γ = 0.99: Γ = 1, 1, γ, γ, γ². Visits at 1, 3, 4: 1 + 0.99 + 0.9801."""
    visits = np.array([b in CYCLE.accepting for b in (0, 3, 0, 3, 3)])
    assert eventual_return(visits, 0.99) == pytest.approx(2.9701)
