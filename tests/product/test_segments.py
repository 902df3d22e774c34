import numpy as np
import pytest

from tests.plan.automata import chain, flatworld_cycle, response, stabilization
from tiloilc.automaton.ldba import Ldba
from tiloilc.plan import stage_plan
from tiloilc.product import Segment, Segmenter, walk_tables

HORIZON = 9


def segmenter(ldba: Ldba, copies: int = 1, cut: bool = True) -> Segmenter:
    return Segmenter(walk_tables(ldba), stage_plan(ldba), copies, HORIZON, 1, cut)


def shown(segments: list[Segment]) -> list[tuple[int, list[int]]]:
    return [(s.buffer, s.observations[:, 0].astype(int).tolist()) for s in segments]


def episode(ldba: Ldba, states: list[int], cut: bool = True) -> list[tuple[int, list[int]]]:
    """The segments of an episode through automaton states; observation t is the number t."""
    collector = segmenter(ldba, cut=cut)
    found = []
    for t, b in enumerate(states):
        found += collector.arrive(np.array([[t]], np.float32), np.array([b]), np.array([True]))
    return shown(found + collector.end(np.array([True])))


def test_the_accepting_state_ends_its_segment_and_is_in_no_other() -> None:
    cycle = [0, 1, 2, 3, 0, 1, 2, 3, 0]
    found = episode(flatworld_cycle(), cycle)
    assert found == [(3, [0, 1, 2, 3]), (3, [4, 5, 6, 7]), (0, [8])]
    everything = [t for _, states in found for t in states]
    assert everything == list(range(len(cycle)))  # each state once, none lost


def test_the_trailing_segment_is_kept() -> None:
    assert episode(flatworld_cycle(), [0, 1, 2, 3, 0, 0]) == [(3, [0, 1, 2, 3]), (0, [4, 5])]


def test_an_unfinished_segment_is_trimmed_after_its_best_stage() -> None:
    assert episode(response(), [1, 1, 2, 2, 1, 1])[0] == (2, [0, 1, 2, 3])


def test_a_segment_that_ends_in_the_sink_is_kept_whole_in_the_sink_buffer() -> None:
    stages = stage_plan(flatworld_cycle())
    assert episode(flatworld_cycle(), [0, 1, 2, 4]) == [(stages.sink_buffer, [0, 1, 2, 3])]
    assert episode(flatworld_cycle(), [2, 4, 4]) == [(stages.sink_buffer, [0, 1, 2])]


def test_after_an_accepting_visit_only_the_rest_goes_to_the_sink_buffer() -> None:
    stages = stage_plan(flatworld_cycle())
    found = episode(flatworld_cycle(), [2, 3, 0, 4])
    assert found == [(3, [0, 1]), (stages.sink_buffer, [2, 3])]


def test_staying_in_acceptance_is_no_segment() -> None:
    assert episode(chain(["a"]), [0, 0, 1, 1, 1, 1]) == [(1, [0, 1, 2])]
    assert episode(stabilization(), [1, 1, 1]) == [(1, [0])]


def test_acceptance_left_and_entered_again_is_a_segment_again() -> None:
    assert episode(response(), [0, 0, 1, 2, 0, 0]) == [(0, [0]), (0, [2, 3, 4])]


def test_leaving_acceptance_for_the_sink_counts_as_failure() -> None:
    stages = stage_plan(stabilization())
    assert episode(stabilization(), [1, 1, 2]) == [(1, [0]), (stages.sink_buffer, [2])]


def test_without_cutting_an_episode_is_one_segment() -> None:
    found = episode(flatworld_cycle(), [0, 1, 2, 3, 0, 1], cut=False)
    assert found == [(3, [0, 1, 2, 3])]  # trimmed: what came after the visit regressed
    stages = stage_plan(flatworld_cycle())
    assert episode(flatworld_cycle(), [2, 3, 4], cut=False) == [(stages.sink_buffer, [0, 1, 2])]


def test_a_segment_never_holds_states_of_two_episodes() -> None:
    collector = segmenter(flatworld_cycle())
    yes = np.array([True])
    for t, b in enumerate([0, 1]):
        collector.arrive(np.array([[t]], np.float32), np.array([b]), yes)
    assert shown(collector.end(yes)) == [(1, [0, 1])]
    for t, b in enumerate([0, 0]):
        collector.arrive(np.array([[10 + t]], np.float32), np.array([b]), yes)
    assert shown(collector.end(yes)) == [(0, [10, 11])]


def test_copies_are_cut_each_on_its_own() -> None:
    collector = segmenter(flatworld_cycle(), copies=2)
    both = np.array([True, True])
    found = []
    for t, row in enumerate([[2, 0], [3, 0], [0, 1]]):
        seen = np.array([[t], [100 + t]], np.float32)
        found += collector.arrive(seen, np.array(row), both)
    assert [(s.copy, *shown([s])[0]) for s in found] == [(0, 3, [0, 1])]
    ended = collector.end(np.array([False, True]))
    assert [(s.copy, *shown([s])[0]) for s in ended] == [(1, 1, [100, 101, 102])]
    assert collector.length.tolist() == [3, 0]


def test_a_full_episode_of_horizon_steps_fits() -> None:
    states = [0] * (HORIZON + 1)
    assert episode(flatworld_cycle(), states) == [(0, list(range(HORIZON + 1)))]


def test_segments_are_copies_that_later_episodes_do_not_overwrite() -> None:
    collector = segmenter(flatworld_cycle())
    yes = np.array([True])
    collector.arrive(np.array([[1]], np.float32), np.array([0]), yes)
    (kept,) = collector.end(yes)
    collector.arrive(np.array([[2]], np.float32), np.array([0]), yes)
    assert kept.observations.tolist() == [[1]]


def test_a_collector_goes_on_from_its_state() -> None:
    first, second = (segmenter(flatworld_cycle()) for _ in range(2))
    yes = np.array([True])
    for t, b in enumerate([3, 0, 1]):
        first.arrive(np.array([[t]], np.float32), np.array([b]), yes)
    second.load({name: array.copy() for name, array in first.state().items()})
    last = np.array([[3]], np.float32), np.array([2]), yes
    assert shown(first.arrive(*last)) == shown(second.arrive(*last))
    assert shown(first.end(yes)) == shown(second.end(yes)) == [(2, [1, 2, 3])]


@pytest.mark.parametrize("b", range(4))
def test_every_live_stage_has_its_own_buffer(b: int) -> None:
    assert episode(flatworld_cycle(), [b])[0][0] == b
