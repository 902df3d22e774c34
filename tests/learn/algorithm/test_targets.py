"""Eq. 4 and Eq. 8 against numbers worked out by hand."""

import numpy as np
import pytest
import torch
from torch import Tensor, tensor

from tests.learn.examples import settings, steps
from tests.plan.automata import chain, flatworld_cycle, response, stabilization
from tiloilc.automaton.ldba import Ldba
from tiloilc.learn.algorithm.tiloil import StageTable, option_values, stage_reward, tiloil_backup
from tiloilc.plan import stage_plan
from tiloilc.product import walk_tables
from tiloilc.spec.settings import Settings

GAMMA = 0.9
MOST = 10.0  # 1 / (1 - γ)
LOST = -10.0  # of a sink that pays -1


def paper(**changes: object) -> Settings:
    """Eq. 4 to the letter, at a discount that makes round numbers."""
    return settings(preset="paper", gamma=GAMMA, **changes)


def target(
    ldba: Ldba,
    given: Settings,
    state: int,
    options: list[int],
    values: list[float],
    reward: float = 0.5,
    terminal: bool = False,
    wait: float | None = None,
) -> float:
    """The target of one transition from b = `state` to the best of `options`."""
    table = StageTable.of(stage_plan(ldba), walk_tables(ldba), given)
    backup = tiloil_backup(
        table,
        steps(tensor([[state]]), tensor([[terminal]])),
        tensor([[options]]),
        tensor([[reward]]),
        given,
        None if wait is None else tensor([[wait]]),
    )
    found = backup.best(tensor([[values]]))
    assert found.shape == (1, 1)
    return found.item()


def reward(ldba: Ldba, given: Settings, states: list[int], bonus: float) -> list[float]:
    table = StageTable.of(stage_plan(ldba), walk_tables(ldba), given)
    return stage_reward(table, tensor([states]), tensor(bonus), given)[0].tolist()


CYCLE = flatworld_cycle()  # 0, 1, 2 are stages, 3 accepts, 4 is the sink
GOAL = chain(["a"])  # 1 accepts for ever
STAY = stabilization()  # 1 accepts while y, 2 is the sink


# Eq. 4, `constant`


def test_outside_acceptance_the_target_is_reward_and_discounted_value() -> None:
    assert target(CYCLE, paper(), 0, [1], [2.0]) == pytest.approx(0.5 + 0.9 * 2)


def test_the_accepting_target_ignores_reward_and_future() -> None:
    assert target(CYCLE, paper(), 3, [0], [-7.0], reward=3.0) == pytest.approx(MOST)


def test_the_accepting_target_is_keyed_on_b_not_on_the_next_b() -> None:
    entering = target(CYCLE, paper(), 2, [3], [2.0])
    assert entering == pytest.approx(0.5 + 0.9 * 2)  # b is not accepting, b' is
    leaving = target(CYCLE, paper(), 3, [0], [2.0])
    assert leaving == pytest.approx(MOST)  # b is accepting, b' is not


def test_entering_acceptance_exactly_is_worth_the_most_possible() -> None:
    given = paper(exact_entry=True)
    assert target(CYCLE, given, 2, [3], [2.0]) == pytest.approx(0.5 + 0.9 * MOST)
    assert target(CYCLE, given, 2, [2], [2.0]) == pytest.approx(0.5 + 0.9 * 2)


def test_entering_a_sink_exactly_is_worth_the_least_possible() -> None:
    given = paper(exact_entry=True)
    assert target(CYCLE, given, 2, [4], [2.0]) == pytest.approx(0.5 + 0.9 * LOST)
    assert target(CYCLE, paper(), 2, [4], [2.0]) == pytest.approx(0.5 + 0.9 * 2)


def test_without_segments_acceptance_has_an_ordinary_target() -> None:
    given = paper(segment=False)
    assert target(CYCLE, given, 3, [0], [2.0]) == pytest.approx(0.5 + 0.9 * 2)


# options


def test_the_best_option_counts() -> None:
    assert target(STAY, paper(), 0, [0, 1], [2.0, 3.0]) == pytest.approx(0.5 + 0.9 * 3)
    assert target(STAY, paper(), 0, [0, 1], [4.0, 3.0]) == pytest.approx(0.5 + 0.9 * 4)
    given = paper(exact_entry=True)
    assert target(STAY, given, 0, [0, 1], [4.0, 3.0]) == pytest.approx(0.5 + 0.9 * MOST)


def test_option_values_are_exact_only_where_told() -> None:
    table = StageTable.of(stage_plan(CYCLE), walk_tables(CYCLE), paper())
    options, soft = tensor([[[0, 3, 4]]]), tensor([[[1.0, 2.0, 3.0]]])
    assert option_values(table, options, paper()).each(soft).tolist() == [[[1, 2, 3]]]
    exact = option_values(table, options, paper(exact_entry=True)).each(soft)
    assert exact.flatten().tolist() == pytest.approx([1, MOST, LOST])


# jumps that take a step


def test_a_jump_that_takes_a_step_is_paid_now_and_worth_what_follows_later() -> None:
    """Staying in 0 is worth 2, the jump 0.25 + 0.9 · 2.5 = 2.5; then it is 0.5 + 0.9 · 2.5."""
    given = paper(epsilon="step")
    assert target(STAY, given, 0, [0, 1], [2.0, 2.5], wait=0.25) == pytest.approx(0.5 + 0.9 * 2.5)
    assert target(STAY, given, 0, [0, 1], [2.0, 2.5], wait=-1.0) == pytest.approx(0.5 + 0.9 * 2)


def test_no_letter_was_read_so_a_jump_into_acceptance_has_no_exact_value() -> None:
    given = paper(epsilon="step", exact_entry=True)
    worth = 0.25 + 0.9 * 2.5
    assert target(STAY, given, 0, [0, 1], [2.0, 2.5], wait=0.25) == pytest.approx(0.5 + 0.9 * worth)


def test_nobody_jumps_where_the_environment_has_ended() -> None:
    given = paper(epsilon="step")
    ended = target(STAY, given, 0, [0, 1], [2.0, 9.0], terminal=True, wait=0.25)
    assert ended == pytest.approx(0.5 + 0.9 * LOST)


# Eq. 4, `live`


@pytest.mark.parametrize(
    ("after", "value", "expected"),
    [
        (1, 4.0, 1 + 0.9 * 4),  # stays: 1 now, and what comes
        (2, 4.0, 1 + 0.9 * LOST),  # falls into the sink
    ],
)
def test_live_acceptance_must_be_kept(after: int, value: float, expected: float) -> None:
    given = paper(accepting_target="live")
    assert target(STAY, given, 1, [after], [value]) == pytest.approx(expected)


def test_live_acceptance_that_recurs_is_the_papers_constant() -> None:
    """Leaving for a live state that does not accept is worth 1 + γ / (1 - γ) = 1 / (1 - γ)."""
    given = paper(accepting_target="live")
    assert target(CYCLE, given, 3, [0], [-7.0], reward=3.0) == pytest.approx(MOST)


def test_live_differs_from_constant_at_acceptance_only() -> None:
    live = paper(accepting_target="live")
    assert target(CYCLE, live, 2, [3], [2.0]) == target(CYCLE, paper(), 2, [3], [2.0])


# `segment`


def test_acceptance_that_begins_a_segment_has_the_target_of_the_state_it_reads_as() -> None:
    given = paper(accepting_target="segment")
    table = StageTable.of(stage_plan(CYCLE), walk_tables(CYCLE), given)
    assert table.code.tolist() == [0, 1, 2, 0, 4]  # after acceptance one waits for r again
    assert target(CYCLE, given, 3, [0], [2.0]) == pytest.approx(0.5 + 0.9 * 2)
    assert reward(CYCLE, given, [3], 0.3) == reward(CYCLE, given, [0], 0.3)


def test_acceptance_that_reads_like_no_other_state_is_live() -> None:
    given = paper(accepting_target="segment")
    for ldba in (GOAL, STAY, response()):
        table = StageTable.of(stage_plan(ldba), walk_tables(ldba), given)
        assert table.code.tolist() == list(ldba.states)
    assert target(STAY, given, 1, [1], [4.0]) == pytest.approx(1 + 0.9 * 4)
    assert target(STAY, given, 1, [2], [4.0]) == pytest.approx(1 + 0.9 * LOST)


def test_states_keep_their_codes_with_the_papers_target() -> None:
    for given in (paper(), paper(accepting_target="segment", segment=False)):
        table = StageTable.of(stage_plan(CYCLE), walk_tables(CYCLE), given)
        assert table.code.tolist() == [0, 1, 2, 3, 4]


# an environment that ends


def test_an_environment_that_has_ended_never_accepts_again() -> None:
    assert target(CYCLE, paper(), 0, [1], [2.0], terminal=True) == pytest.approx(0.5 + 0.9 * LOST)


@pytest.mark.parametrize("given", [{"exact_entry": True}, {}, {"segment": False}])
def test_an_environment_that_ends_in_acceptance_has_its_worth(given: dict[str, bool]) -> None:
    """No step leads on from there, so nothing but the target can say so."""
    given = paper(**given)
    assert target(CYCLE, given, 2, [3], [2.0], terminal=True) == pytest.approx(0.5 + 0.9 * MOST)


@pytest.mark.parametrize("exact", [True, False])
def test_where_an_environment_has_ended_the_best_option_is_the_one_that_accepts(
    exact: bool,
) -> None:
    given = paper(exact_entry=exact)
    ended = target(STAY, given, 0, [0, 1], [50.0, 3.0], terminal=True)
    assert ended == pytest.approx(0.5 + 0.9 * MOST)


@pytest.mark.parametrize("kind", ["live", "segment"])
def test_acceptance_that_is_kept_when_the_environment_ends_is_kept_for_ever(kind: str) -> None:
    given = paper(accepting_target=kind)
    assert target(STAY, given, 1, [1], [2.0], terminal=True) == pytest.approx(1 + 0.9 * MOST)


@pytest.mark.parametrize("kind", ["live", "segment"])
def test_acceptance_cannot_be_kept_nor_left_once_the_environment_has_ended(kind: str) -> None:
    given = paper(accepting_target=kind)
    ended = target(response(), given, 0, [1], [2.0], terminal=True)
    assert ended == pytest.approx(1 + 0.9 * LOST)


# Eq. 8


def test_the_reward_is_stage_and_discriminator_over_the_longest_way() -> None:
    third = paper(beta="1/3")
    assert reward(CYCLE, third, [0, 1, 2], 0.6) == pytest.approx([0.2 / 3, 1.2 / 3, 2.2 / 3])


def test_without_stages_the_reward_is_the_discriminators() -> None:
    given = paper(stages=False)
    assert reward(CYCLE, given, [0, 1, 2], 0.6) == pytest.approx([0.6, 0.6, 0.6])


@pytest.mark.parametrize("beta", [0.0, 1 / 3, 0.49])
def test_a_later_stage_pays_more_whatever_the_discriminators_say(beta: float) -> None:
    given = paper(beta=beta)
    for b in (0, 1):
        assert reward(CYCLE, given, [b], 1.0)[0] < reward(CYCLE, given, [b + 1], -1.0)[0]


@pytest.mark.parametrize("stages", [True, False])
def test_a_sink_pays_its_own_reward_whatever_its_stage(stages: bool) -> None:
    given = paper(stages=stages, sink_reward=-0.5)
    assert reward(CYCLE, given, [4], 1.0) == [-0.5]


def test_a_sink_pays_less_than_any_live_state_so_that_nobody_dies_to_be_better_off() -> None:
    for preset in ("paper", "default"):
        given = settings(preset=preset, gamma=GAMMA)
        worst_alive = min(reward(CYCLE, given, [0, 1, 2], -1.0))
        assert reward(CYCLE, given, [4], 1.0)[0] < worst_alive
        value_of_worst_life = worst_alive / (1 - GAMMA)
        assert given.sink_reward / (1 - GAMMA) < value_of_worst_life


def test_a_sinks_exact_value_is_its_rewards_for_ever() -> None:
    given = paper(exact_entry=True)
    assert target(CYCLE, given, 4, [4], [0.0], reward=-1.0) == pytest.approx(LOST)


# axes


def test_seeds_and_rows_are_independent() -> None:
    """A batch [seed, n] gives what each of its transitions gives alone."""
    given = paper(accepting_target="live", exact_entry=True)
    table = StageTable.of(stage_plan(STAY), walk_tables(STAY), given)
    rng = np.random.default_rng(0)
    shape = (3, 7)
    state: Tensor = torch.from_numpy(rng.integers(3, size=shape))
    options = torch.from_numpy(rng.integers(3, size=(*shape, 2)))
    pay, soft = (
        torch.from_numpy(rng.normal(size=shape)),
        torch.from_numpy(rng.normal(size=(*shape, 2))),
    )
    terminal = torch.from_numpy(rng.random(shape) < 0.3)
    together = tiloil_backup(table, steps(state, terminal), options, pay, given).best(soft)
    for i in range(3):
        for j in range(7):
            alone = target(
                STAY,
                given,
                int(state[i, j]),
                options[i, j].tolist(),
                soft[i, j].tolist(),
                float(pay[i, j]),
                bool(terminal[i, j]),
            )
            assert together[i, j].item() == pytest.approx(alone, rel=1e-5)
