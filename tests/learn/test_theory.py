"""Tabular TiLoIL against theory: exact soft value iteration, and theorem 3.2 of the paper."""

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.learn.exact import (
    ACTIONS,
    GAMMA,
    MOST,
    PASSING,
    PRODUCTS,
    RING,
    RISKY,
    SIZE,
    STAY,
    Values,
    exact,
    labels_of,
    moved,
    pay_of,
    soft_values,
    swept,
    task,
)
from tiloilc.automaton.ldba import Ldba
from tiloilc.demos import DemoSet
from tiloilc.learn import make_loop
from tiloilc.learn.agent.tabular import TabularAgent
from tiloilc.plan import Plan

TIGHT = 2e-5
"""Tables are float32: 10 is exact to 1e-6, and the fixed point adds up 1 / (1 - γ) such errors."""

ALPHAS = (0.0, 0.2, 1.0)


@pytest.mark.parametrize("exact_entry", [False, True])
@pytest.mark.parametrize("kind", ["constant", "live"])
@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("name", sorted(PRODUCTS))
def test_q_learning_finds_the_fixed_point_of_equation_4(
    name: str, alpha: float, kind: str, exact_entry: bool
) -> None:
    """With sinks, with a cycle, with acceptance that must be kept, with a jump that is free."""
    made = task(PRODUCTS[name], accepting_target=kind, exact_entry=exact_entry, entropy=alpha)
    assert np.abs(swept(made).q[0].numpy() - exact(made)).max() < TIGHT


@pytest.mark.parametrize("exact_entry", [False, True])
@pytest.mark.parametrize("kind", ["constant", "live"])
@pytest.mark.parametrize("alpha", ALPHAS)
def test_so_it_does_on_the_product_of_definition_2_3(
    alpha: float, kind: str, exact_entry: bool
) -> None:
    """A jump is an action of its own: s stays, no label is read, a step passes."""
    made = task(STAY, epsilon="step", accepting_target=kind, exact_entry=exact_entry, entropy=alpha)
    found, wanted = swept(made).q[0].numpy(), exact(made)
    assert np.abs(found - wanted).max() < TIGHT


def test_a_jump_that_takes_a_step_is_another_product_than_one_that_is_free() -> None:
    """At once in acceptance by the jump alone, from anywhere: the letter is not read.

    Free: from cell 2 yellow is two steps away, 0 + γ (0 + γ 10) = 8.1 by the better action.
    A step each: from cell 2 to 3 and then the jump, 0 + γ (0 + γ 10) = 8.1; but so it is from
    cell 2 to 2, where no yellow is near.
    """
    free, step = (exact(task(STAY, exact_entry=True, epsilon=e)) for e in ("free", "step"))
    toward, still = 2, 1
    assert free[2, 0, toward] == pytest.approx(8.1)
    assert free[2, 0, still] == pytest.approx(0.9 * 8.1)
    assert step[2, 0, toward] == step[2, 0, still] == pytest.approx(8.1)


@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("name", sorted(PRODUCTS))
def test_without_segments_it_is_ordinary_soft_value_iteration(name: str, alpha: float) -> None:
    made = task(PRODUCTS[name], segment=False, entropy=alpha)
    assert np.abs(swept(made).q[0].numpy() - exact(made)).max() < TIGHT


@pytest.mark.parametrize(
    ("ldba", "changes"),
    [
        (RISKY, {"end_on_sink": True}),
        (STAY, {"accepting_target": "live", "entropy": 0.2}),
        (STAY, {"accepting_target": "live", "epsilon": "step"}),
    ],
    ids=["risky", "stay", "stay-step"],
)
def test_an_agent_that_acts_and_learns_comes_to_the_same_values(
    ldba: Ldba, changes: dict[str, object]
) -> None:
    """The whole loop: environment, labels, jumps, time limits, replayed backwards; f kept out.

    Episodes of 7 steps: whoever took their ends for real ones would find smaller values.
    """
    made = task(
        ldba,
        **{
            "steps": 800,
            "learning_starts": 0,
            "exploration": 1.0,
            "beta": 0.0,
            "relabel": True,
            "exact_entry": True,
            **changes,
        },
    )
    loop = make_loop(made, DemoSet(()), labels_of(ldba))
    loop.horizon = loop.product.horizon = 7
    for _ in loop.run(800):
        pass
    assert isinstance(loop.agent, TabularAgent)
    live = [b for b in ldba.states if b != ldba.sink]
    found = loop.agent.q[0].numpy()[:, live]
    assert np.abs(found - exact(made)[:, live]).max() < 1e-3


# theorem 3.2


def ordinary(made: Plan) -> Values:
    """Q* of ordinary soft Bellman backups, acceptance being a state like any other."""
    return exact(task(made.ldba, segment=False, entropy=made.train.entropy))


def policy_of(q: Values, alpha: float) -> Values:
    """π ∝ exp(Q / α), as the theorem assumes; all on the greatest Q if α = 0."""
    if alpha == 0:
        return np.eye(q.shape[-1])[q.argmax(-1)]
    weight = np.exp((q - q.max(-1, keepdims=True)) / alpha)
    return np.asarray(weight / weight.sum(-1, keepdims=True))


def entropies(policy: Values) -> Values:
    return -(policy * np.log(np.where(policy > 0, policy, 1))).sum(-1)


def discounted_arrival(made: Plan, policy: Values) -> Values:
    """E[γ^k] for each (s, b) and first action, k being the steps until π is in acceptance."""
    ldba = made.ldba
    letters = labels_of(ldba)(np.arange(SIZE, dtype=np.float32)[:, None])
    worth = np.zeros((SIZE, len(ldba.states), ACTIONS))
    for _ in range(400):
        state = (policy * worth).sum(-1)
        for cell in range(SIZE):
            for b in ldba.states:
                for action in range(ACTIONS):
                    after = moved(cell, action)
                    c = ldba.successor(b, int(letters[after]))
                    worth[cell, b, action] = GAMMA * state[after, c]
                    if b in ldba.accepting:
                        worth[cell, b, action] = 1.0  # k = 0
    return worth


def gap(made: Plan, policy: Values, missing: float = 0.0) -> float:
    """δ_max, with R_min and H_min of what can happen; `missing` is added to it."""
    least = min(pay_of(made, b) for b in made.ldba.states)
    alpha = float(made.train.entropy)
    return MOST - (least + alpha * float(entropies(policy).min())) * MOST + missing


@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("name", ["passing", "ring", "risky"])
def test_theorem_3_2_bounds_what_the_constant_target_overestimates(name: str, alpha: float) -> None:
    """Q - Q* ≤ γ^k δ_max, in the mean over the k that the soft policy takes (deterministic b)."""
    ldba = PRODUCTS[name]
    made = task(ldba, entropy=alpha)
    learned = swept(made).q[0].double().numpy()
    policy = policy_of(learned, alpha)
    excess = learned - ordinary(made)
    bound = discounted_arrival(made, policy) * gap(made, policy)
    assert (excess <= bound + TIGHT).all()
    assert (excess > 0.1 * bound).any() or ldba is PASSING  # whose acceptance pays 1 for ever


@pytest.mark.parametrize("alpha", [0.0, 0.2])
def test_overestimation_decays_with_the_distance_to_acceptance(alpha: float) -> None:
    """What lies k steps before acceptance is γ^k of what lies at it, and not less by chance."""
    made = task(RING, entropy=alpha)
    excess = (swept(made).q[0].double().numpy() - ordinary(made)).max(-1)
    along = [excess[cell, 1] for cell in (1, 2, 3, 4)]  # in b = 1 one walks left to cell 0
    assert all(near > far > 0 for near, far in pairwise(along))
    assert excess[0, 2] > along[0]


def test_the_theorems_constant_lacks_the_entropy_of_the_first_step() -> None:
    """Where the proof is loose: Q, unlike V, has no entropy term for its own action.

    One accepting state that goes on for ever, R = 0, three equal actions, π uniform:
    Q* = 0 + γ (α log 3) / (1 - γ), which is α log 3 less than (R_min + α H_min) / (1 - γ). So at
    acceptance, k = 0, the excess is δ_max + α log 3; with α H_min added the bound holds.
    """
    alpha = 1.0
    entropy = math.log(ACTIONS)
    star = GAMMA * alpha * entropy / (1 - GAMMA)
    excess = MOST - star
    printed = MOST - (0.0 + alpha * entropy) * MOST
    assert excess == pytest.approx(printed + alpha * entropy)
    assert excess > printed


def test_the_value_of_a_state_is_that_of_the_policy_that_the_theorem_assumes() -> None:
    """α log Σ exp(Q / α), the learner's form, is E_π[Q − α log π] for π ∝ exp(Q / α).

    Q = (1, 0), α = 1/2: π = (e², 1) / (e² + 1) and ½ log(e² + 1) = 1.0634640...
    """
    q = np.array([1.0, 0.0])
    assert soft_values(q, 0.5) == pytest.approx(0.5 * math.log(math.e**2 + 1))
    assert 0.5 * math.log(math.e**2 + 1) == pytest.approx(1.0634640, abs=1e-7)
