"""Traps: what is wrong in reinforcement learning from automata without an error to say so.

The table names, for each trap, the tests that fall into it if the code does. Those that are written
nowhere else follow it.
"""

import ast
from dataclasses import dataclass
from functools import cache
from itertools import product as words
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.learn.exact import GAMMA, MOST, RING, SIZE, STAY, learn_all, swept, task
from tests.learn.examples import settings
from tests.plan.automata import flatworld_cycle, ring
from tests.product import worlds  # noqa: F401  # registers
from tiloilc.automaton import translate
from tiloilc.automaton.ldba import Ldba
from tiloilc.learn.algorithm.tiloil import StageTable, stage_reward
from tiloilc.ltl import parse
from tiloilc.plan import stage_plan
from tiloilc.product import Copies, Product, walk_tables
from tiloilc.spec.model import Environment

TESTS = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Trap:
    """What goes wrong, and `file::test` of what notices, or why it cannot happen here."""

    what: str
    tests: tuple[str, ...] = ()
    not_here: str = ""


LOOP, TARGETS, TABULAR = (
    "learn/run/test_loop.py",
    "learn/algorithm/test_targets.py",
    "learn/agent/test_tabular.py",
)
JUDGES, AGENT, THEORY = (
    "learn/algorithm/test_discriminators.py",
    "learn/agent/test_continuous.py",
    "learn/test_theory.py",
)
HERE, SEGMENTS, STAGES = "learn/test_traps.py", "product/test_segments.py", "plan/test_stages.py"
LINT, TRANSLATE, REPLAYED = (
    "driver/test_lint.py",
    "automaton/test_translate.py",
    "demos/test_replay.py",
)
ROLLOUT, PRODUCT, WALK = (
    "evaluate/test_rollout.py",
    "product/test_product.py",
    "product/test_walk.py",
)
NO_BASELINE = "of a baseline that is not built yet: "

TRAPS = {
    1: Trap(
        "the time limit taken for a terminal state",
        (
            f"{LOOP}::test_the_time_limit_is_not_terminal",
            f"{THEORY}::test_an_agent_that_acts_and_learns_comes_to_the_same_values",
        ),
    ),
    2: Trap(
        "the accepting target keyed on b' instead of b, or on both",
        (f"{TARGETS}::test_the_accepting_target_is_keyed_on_b_not_on_the_next_b",),
    ),
    3: Trap(
        "Eq. 8 with b' in one place and b in the other",
        (
            f"{HERE}::test_stage_way_and_discriminator_are_all_those_of_b",
            f"{AGENT}::test_targets_are_equation_4_with_the_soft_value_of_the_next_state",
        ),
    ),
    4: Trap(
        "b' from the label of s",
        (
            f"{PRODUCT}::test_labels_are_of_the_state_arrived_in_not_of_the_one_left",
            f"{LOOP}::test_a_step_is_stored_with_the_state_before_it_and_the_letter_after_it",
        ),
    ),
    5: Trap(
        "the first label read in training but not in evaluation or demonstrations",
        (
            f"{PRODUCT}::test_the_label_of_the_first_state_is_read",
            f"{ROLLOUT}::test_a_rollout_has_the_first_state_and_one_for_each_step_of_the_horizon",
            f"{REPLAYED}::test_the_first_label_is_read_before_the_first_step",
        ),
    ),
    6: Trap(
        "jumps that read no label with a constant target: to jump at once is best",
        (
            f"{HERE}::test_to_jump_at_once_is_best_only_without_a_letter_and_with_a_constant",
            f"{LINT}::test_jumping_at_once_is_named_where_it_would_be_best",
        ),
    ),
    7: Trap(
        "jumps out of sinks, or chosen uniformly with actions while warming up",
        (
            f"{WALK}::test_nobody_is_offered_to_jump_into_the_sink_or_out_of_it",
            f"{WALK}::test_a_jump_that_takes_a_step_begins_where_the_letter_led",
            f"{LOOP}::test_nobody_jumps_into_a_sink_while_exploring",
        ),
    ),
    8: Trap(
        "MaxStage with ties, cycles or none; the sink never returned",
        (
            f"{STAGES}::test_equal_distances_go_to_the_larger_index_then_to_the_last_visit",
            f"{STAGES}::test_a_segment_that_ends_in_the_sink_is_kept_whole",
            "learn/algorithm/test_equations.py::test_the_stage_that_is_taken_is_one_that_equation_7_names",
        ),
    ),
    9: Trap(
        "sinks only as literal self-loops",
        (
            f"{TRANSLATE}::test_what_can_no_longer_accept_is_one_sink",
            f"{TRANSLATE}::test_a_mark_on_no_cycle_is_dropped",
        ),
    ),
    10: Trap(
        "the stage index of a sink is high",
        (f"{TARGETS}::test_a_sink_pays_its_own_reward_whatever_its_stage",),
    ),
    11: Trap(
        "a sink that pays more than life",
        (
            f"{TARGETS}::test_a_sink_pays_less_than_any_live_state_so_that_nobody_dies_to_be_better_off",
            f"{LINT}::test_a_fault_is_found_and_placed",
        ),
    ),
    12: Trap(
        "a fixed temperature with a constant accepting value: lingering",
        (
            f"{HERE}::test_with_a_high_temperature_lingering_is_worth_more_than_acceptance",
            f"{LINT}::test_a_fault_is_found_and_placed",
        ),
    ),
    13: Trap(
        "flat Q at absorbing acceptance: judge the mean action, report both",
        (
            f"{HERE}::test_a_constant_target_leaves_acceptance_without_advice",
            "evaluate/test_protocol.py::test_what_is_written_of_a_run",
        ),
    ),
    14: Trap(
        "visits that count dwelling compared with visits that count laps",
        (f"{STAGES}::test_acceptance_is_absorbing_where_it_must_only_be_kept",),
    ),
    15: Trap(
        "the boundary state in both segments or in neither; the trailing segment lost",
        (
            f"{SEGMENTS}::test_the_accepting_state_ends_its_segment_and_is_in_no_other",
            f"{SEGMENTS}::test_the_trailing_segment_is_kept",
        ),
    ),
    16: Trap(
        "sinks missing from the negatives, or the fatal state trimmed away",
        (
            f"{JUDGES}::test_the_sink_buffer_is_among_the_negatives_of_every_stage",
            f"{SEGMENTS}::test_a_segment_that_ends_in_the_sink_is_kept_whole_in_the_sink_buffer",
        ),
    ),
    17: Trap(
        "stale stored rewards",
        (
            f"{AGENT}::test_rewards_are_those_of_todays_discriminators",
            f"{TABULAR}::test_the_reward_is_that_of_todays_discriminators",
        ),
    ),
    18: Trap(
        "trajectories sampled instead of states; demonstrations dominating or vanishing",
        (
            f"{JUDGES}::test_states_of_a_union_are_drawn_uniformly_not_buffers_nor_segments",
            f"{JUDGES}::test_the_share_of_demonstrations_in_a_positive_batch_is_as_told",
            f"{JUDGES}::test_counts_take_their_share_of_demonstrations",
        ),
    ),
    19: Trap(
        "a discriminator's input that gives the answer away",
        (f"{JUDGES}::test_discriminators_see_normalised_states_and_nothing_else",),
    ),
    20: Trap(
        "untrained discriminators add noise",
        (
            f"{JUDGES}::test_an_untrained_discriminator_adds_nothing",
            f"{JUDGES}::test_one_side_alone_teaches_nothing",
        ),
    ),
    21: Trap(
        "states that are not normalised into a small network",
        (
            f"{JUDGES}::test_the_running_norm_is_that_of_everything_seen",
            f"{JUDGES}::test_discriminators_see_normalised_states_and_nothing_else",
        ),
    ),
    22: Trap(
        "a horizon that is off by one",
        (
            f"{LOOP}::test_an_episode_has_horizon_steps",
            f"{LOOP}::test_an_episode_has_horizon_steps_jumps_included",
            f"{ROLLOUT}::test_a_rollout_has_the_first_state_and_one_for_each_step_of_the_horizon",
        ),
    ),
    23: Trap(
        "labels asked of the live simulator when stored states are relabelled",
        (
            f"{AGENT}::test_letters_in_the_replay_are_those_of_the_state_arrived_in",
            f"{TABULAR}::test_relabelled_steps_have_the_same_fixed_point",
        ),
    ),
    24: Trap(
        "labels in one place that every step writes over",
        (f"{HERE}::test_labels_and_states_handed_out_never_change_later",),
    ),
    25: Trap(
        "strictness at boundaries, and states with several labels",
        (
            f"{HERE}::test_where_a_goal_is_also_deadly_the_sink_wins",
            "label/test_predicates.py::test_a_predicate_means_what_numpy_says",
            "tasks/test_finite_models.py::"
            "test_no_lattice_point_is_so_near_a_rim_that_rounding_could_label_it",
        ),
    ),
    26: Trap(
        "demonstrations with another start, time step or layout",
        (
            "demos/test_recording.py::test_bundled_demonstrations_of_another_variant_are_not_taken",
            f"{REPLAYED}::test_components_are_compared_with_the_environments",
            "demos/test_recording.py::test_bundled_actions_lead_from_each_state_to_the_next",
        ),
    ),
    27: Trap(
        "counterfactual replay with the reward of the actual b",
        (
            f"{TABULAR}::test_relabelled_steps_have_the_same_fixed_point",
            f"{AGENT}::"
            "test_relabelled_steps_are_read_from_every_live_state_and_demonstrations_as_they_went",
        ),
    ),
    28: Trap(
        "γ = 1 outside acceptance: singular or diverging",
        (
            "spec/test_spec.py::"
            "test_every_number_has_a_limit_beyond_which_it_is_a_finding_at_its_place",
        ),
    ),
    29: Trap(
        "another order in the chain than in the demonstrations",
        (
            f"{TRANSLATE}::test_a_cycle_goes_round_in_the_written_order_and_accepts_at_its_end",
            f"{REPLAYED}::test_the_stage_that_none_leaves_is_named",
            f"{LINT}::test_a_fault_is_found_and_placed",
        ),
    ),
    30: Trap(
        "acceptance of edges moved to the wrong end: counts off by one",
        (f"{HERE}::test_a_visit_comes_with_the_letter_that_completes_it",),
    ),
    31: Trap("parallel cycles from disjunctive guards", not_here=NO_BASELINE + "CyclER"),
    32: Trap(
        "whole-numbered reward arrays truncate",
        (f"{HERE}::test_rewards_are_fractions_though_stages_are_whole_numbers",),
    ),
    33: Trap(
        "a crash that ends the episode for one method and not for another",
        not_here=NO_BASELINE + "one loop ends the episodes of all that is trained",
    ),
    34: Trap(
        "targets that never move in a short run",
        (f"{LINT}::test_a_fault_is_found_and_placed",),
    ),
    35: Trap(
        "global randomness in environments",
        (
            "product/test_copies.py::test_environments_use_no_global_randomness",
            f"{LOOP}::test_global_randomness_plays_no_part",
        ),
    ),
    36: Trap(
        "transitions across a reset stored as real",
        (
            f"{LOOP}::test_no_transition_crosses_a_reset",
            "product/test_copies.py::test_a_batched_form_that_resets_by_itself_is_not_used",
        ),
    ),
}


@cache
def defined_in(file: str) -> frozenset[str]:
    """The tests that a file defines."""
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    return frozenset(f.name for f in tree.body if isinstance(f, ast.FunctionDef))


@pytest.mark.parametrize("number", range(1, 37))
def test_every_trap_has_its_test_or_cannot_happen_here(number: int) -> None:
    trap = TRAPS[number]
    assert bool(trap.tests) != bool(trap.not_here)
    for test in trap.tests:
        file, _, name = test.partition("::")
        assert name in defined_in(file), f"trap {number}, {trap.what}: there is no {test}"


CYCLE = flatworld_cycle()


def test_stage_way_and_discriminator_are_all_those_of_b(monkeypatch: pytest.MonkeyPatch) -> None:
    """Trap 3. SIDX = 0, 1, N = 2 on the ring, and another f for each b and cell: (b + β f) / 2."""
    found = swept(task(RING, beta="1/3"), sweeps=1)
    values = found.method.discriminators.values[0]
    values.copy_(torch.linspace(-0.9, 0.9, values.numel()).view_as(values))
    q = found.q.clone()
    monkeypatch.setattr(found.method, "learn", lambda chance: {})
    learn_all(found, 1)  # with step size 1: the new Q is the target
    for b in (0, 1):
        for cell in (2, 3):  # to stand still there changes nothing, b' = b
            value = GAMMA * q[0, cell, b].max()
            own = values[b, cell].item()
            assert found.q[0, cell, b, 1].item() == pytest.approx((b + own / 3) / 2 + value.item())
    pay = (1 + values[1, 1].item() / 3) / 2  # from cell 1 to the left b' accepts; b = 1 is paid
    assert found.q[0, 1, 1, 0].item() == pytest.approx(pay + GAMMA * q[0, 0, 2].max().item())


def test_to_jump_at_once_is_best_only_without_a_letter_and_with_a_constant() -> None:
    """Trap 6. In cell 2, two steps from yellow, to stand still and jump: as good as to walk there.

    With the letter read, or where acceptance must be kept, it is not.
    """
    toward, still = 2, 1

    def gain(**changes: object) -> float:
        q = swept(task(STAY, exact_entry=True, **changes)).q[0]
        return float(q[2, 0, toward] - q[2, 0, still])

    assert gain(epsilon="step", accepting_target="constant") == pytest.approx(0, abs=1e-5)
    assert gain(epsilon="free", accepting_target="constant") > 0.5
    assert gain(epsilon="step", accepting_target="live") > 0.5
    assert gain(epsilon="free", accepting_target="live") > 0.5


def test_with_a_high_temperature_lingering_is_worth_more_than_acceptance() -> None:
    """Trap 12. Uniform over three actions for ever: α log 3 / (1 − γ) = 10.99 for α = 1, not 10.

    With plain maxima acceptance is worth the most everywhere.
    """
    cold, hot = (swept(task(RING, entropy=alpha)).q[0, :, 0].max() for alpha in (0.0, 1.0))
    assert np.log(3) / (1 - GAMMA) > MOST
    assert cold < MOST < hot


def test_a_constant_target_leaves_acceptance_without_advice() -> None:
    """Trap 13. In acceptance that must be kept every action is worth as much; `live` tells them."""
    constant, live = (
        swept(task(STAY, accepting_target=kind, exact_entry=True)).q[0, SIZE - 1, 1]
        for kind in ("constant", "live")
    )
    assert constant.tolist() == pytest.approx([MOST] * 3)
    assert live.argmin() == 0  # to leave yellow
    assert live[1:].min() > live[0] + 1


def test_labels_and_states_handed_out_never_change_later() -> None:
    """Trap 24."""
    copies = Copies(Environment(id="TestsLine-v0", horizon=9), 2)
    many = Product(
        copies,
        lambda seen: seen[:, 0].astype(np.int64) % 2,
        walk_tables(ring(["odd"], "never")),
        lambda seen, options: options[:, 0],
    )
    many.reset([0, 0], np.ones(2, dtype=np.bool_))
    handed = []
    for _ in range(3):
        many.step(np.array([2, 2]))
        now = many.letters, many.states, many.observations, many.elapsed
        handed.append((now, [array.copy() for array in now]))
    for now, then in handed:
        assert all(np.array_equal(a, b) for a, b in zip(now, then, strict=True))


def test_where_a_goal_is_also_deadly_the_sink_wins() -> None:
    """Trap 25. Red and blue at once is a violation and no visit, in every state that lives."""
    parsed = parse("G F (r & X F (g & X F y)) & G !b")
    for ldba in (translate(parsed.formula, parsed.propositions), CYCLE):
        for b in ldba.states:
            for goal in ("r", "g", "y"):
                assert ldba.options(b, ldba.letter([goal, "b"])) == (ldba.sink,)


def marks(ldba: Ldba, word: tuple[int, ...]) -> list[bool]:
    """Which letters of a word are read on an edge that accepts."""
    state, found = ldba.initial, []
    for letter in word:
        (index,) = (
            i
            for i in ldba.outgoing_indices[state]
            if any(letter in cube for cube in ldba.edges[i].guard)
        )
        found.append(index in ldba.accepting_edges)
        state = ldba.edges[index].target
    return found


@pytest.mark.parametrize("text", ["G F (a & X F b)", "G (a -> X F b)", "G F a & G F b"])
def test_a_visit_comes_with_the_letter_that_completes_it(text: str) -> None:
    """Trap 30. On states the visit is the arrival, on edges it is the edge: at the same letter."""
    parsed = parse(text)
    on_states = translate(parsed.formula, parsed.propositions)
    on_edges = translate(parsed.formula, parsed.propositions, acceptance="edge")
    assert not on_states.jumps
    for word in words(range(4), repeat=4):
        arrivals = [b in on_states.accepting for b in on_states.run(word)]
        assert arrivals == marks(on_edges, word)


def test_rewards_are_fractions_though_stages_are_whole_numbers() -> None:
    """Trap 32. SIDX and N are integers, (2 + 0) / 3 is none."""
    given = settings(preset="paper")
    table = StageTable.of(stage_plan(CYCLE), walk_tables(CYCLE), given)
    reward = stage_reward(table, torch.tensor([[2]]), torch.tensor([[0.0]]), given)
    assert reward.dtype == torch.float32
    assert reward.item() == pytest.approx(2 / 3)
