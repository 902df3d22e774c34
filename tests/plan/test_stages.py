from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.plan.automata import (
    automaton,
    chain,
    disjunction,
    flatworld_cycle,
    response,
    stabilization,
)
from tiloilc.diag import CompileError
from tiloilc.plan.longest import longest_paths
from tiloilc.plan.stages import (
    ambiguous_stages,
    is_absorbing,
    max_stage,
    stage_findings,
    stage_graph,
    stage_plan,
)


def test_flatworld_cycle_has_the_papers_stage_numbers() -> None:
    stages = stage_plan(flatworld_cycle())
    assert stages.index == (0, 1, 2, 3, 0)
    assert stages.length == (3, 3, 3, 3, 1)
    assert stages.distance == (3, 2, 1, 0, -1)


def test_flatworld_cycle_compares_later_stages_with_earlier_ones() -> None:
    stages = stage_plan(flatworld_cycle())
    assert stages.positive == ((1, 2, 3), (2, 3), (3,), (), ())
    assert stages.negative == ((0, 5), (0, 1, 5), (0, 1, 2, 5), (), ())
    assert stages.sink_buffer == 5


def test_a_jump_and_the_edge_after_it_are_one_edge() -> None:
    stages = stage_plan(stabilization())
    assert stage_graph(stabilization()) == ((0, 1), (1,), ())
    assert stages.index == (0, 1, 0)
    assert stages.length == (1, 1, 1)
    assert stages.positive[0] == (1,)


def test_segments_may_begin_in_an_accepting_start() -> None:
    stages = stage_plan(response())
    assert stages.index == (0, 1, 2)
    assert stages.length == (3, 3, 3)
    assert stages.distance == (0, 2, 1)


def test_the_longer_way_through_a_disjunction_counts() -> None:
    stages = stage_plan(disjunction())
    assert stages.index == (0, 1, 2, 3)
    assert stages.length == (3, 3, 3, 3)
    assert stages.positive[1] == (2, 3)
    assert stages.negative[2] == (0, 1, 2, 4)


def test_a_cycle_without_acceptance_is_split_by_the_distance() -> None:
    def step(b: int, true: set[str]) -> int:
        return (b + 1 if "a" in true else 0) if b < 2 else 2

    stages = stage_plan(automaton(["a"], 3, step, {2}))
    assert stages.distance == (2, 1, 0)
    assert stages.positive == ((1, 2), (2,), ())
    assert stages.negative == ((0, 3), (0, 1, 3), ())


def test_states_behind_acceptance_count_from_there() -> None:
    def step(b: int, true: set[str]) -> int:
        return (b + 1) if "a" in true and b < 3 else (1 if b == 3 else b)

    stages = stage_plan(automaton(["a"], 4, step, {1}))
    assert stages.index == (0, 1, 1, 2)
    assert stages.length[2:] == (3, 3)


def test_a_side_track_still_has_a_reward_below_one() -> None:
    def step(b: int, true: set[str]) -> int:
        return {0: 1, 1: 3 if "a" in true else 2, 2: 1, 3: 3}[b]

    stages = stage_plan(automaton(["a"], 4, step, {3}))
    assert stages.index == (0, 1, 2, 2)
    assert stages.length[2] == 4


def test_without_an_accepting_state_in_reach_there_are_no_stages() -> None:
    with pytest.raises(CompileError, match="PLAN402"):
        stage_plan(automaton(["a"], 2, lambda b, true: b, {1}))


def test_a_segment_belongs_to_the_stage_nearest_to_acceptance_and_is_trimmed_after_it() -> None:
    stages = stage_plan(flatworld_cycle())
    assert max_stage(stages, [0, 0, 1, 1, 2, 3]) == (3, 6)
    assert max_stage(stages, [0, 1, 1]) == (1, 3)
    assert max_stage(stages, np.array([0, 0])) == (0, 2)


def test_a_segment_that_ends_in_the_sink_is_kept_whole() -> None:
    stages = stage_plan(flatworld_cycle())
    assert max_stage(stages, [0, 1, 2, 4, 4]) == (stages.sink_buffer, 5)


def test_what_regressed_is_trimmed_away() -> None:
    def step(b: int, true: set[str]) -> int:
        return (b + 1 if "a" in true else 0) if b < 2 else 2

    stages = stage_plan(automaton(["a"], 3, step, {2}))
    assert max_stage(stages, [0, 1, 0, 1, 0, 0]) == (1, 4)


def test_equal_distances_go_to_the_larger_index_then_to_the_last_visit() -> None:
    stages = stage_plan(disjunction())
    assert max_stage(stages, [0, 1, 1, 2, 2]) == (2, 5)
    assert max_stage(stages, [2, 1]) == (2, 1)

    def step(b: int, true: set[str]) -> int:
        return 3 if b == 3 or "c" in true else (1 if "a" in true else 2)

    both = stage_plan(automaton(["a", "c"], 4, step, {3}))
    assert both.index[1] == both.index[2]
    assert max_stage(both, [1, 2, 1, 0]) == (1, 3)
    assert max_stage(both, [1, 2]) == (2, 2)


def test_ambiguity_is_told_with_its_tie_break() -> None:
    ldba = disjunction()
    stages = stage_plan(ldba)
    assert ambiguous_stages(ldba, stages) == ((1, 2),)
    codes = {d.code: d.message for d in stage_findings(ldba, stages)}
    assert set(codes) == {"PLAN403", "PLAN405"}
    assert "states 1 and 2" in codes["PLAN403"]
    assert "state 2 counts" in codes["PLAN403"]


def test_rings_are_unambiguous_and_not_absorbing() -> None:
    ldba = flatworld_cycle()
    assert stage_findings(ldba, stage_plan(ldba)) == []


def test_acceptance_is_absorbing_where_it_must_only_be_kept() -> None:
    assert is_absorbing(chain(["a", "b"]))
    assert is_absorbing(stabilization())
    assert not is_absorbing(response())


def test_large_components_are_counted_as_one_and_reported() -> None:
    names = ["a", "b", "c", "d"]

    def step(b: int, true: set[str]) -> int:
        letter = sum(1 << i for i, name in enumerate(names) if name in true)
        return letter if b < 16 else 16

    def last(b: int, true: set[str]) -> int:
        return 16 if b == 15 and not true else step(b, true)

    ldba = automaton(names, 17, last, {16})
    stages = stage_plan(ldba)
    assert stages.index[16] == 1
    assert "PLAN406" in {d.code for d in stage_findings(ldba, stages)}


@settings(max_examples=200, deadline=None)
@given(st.integers(2, 6), st.data())
def test_longest_paths_are_those_of_a_search_through_all_permutations(
    n: int, data: st.DataObject
) -> None:
    bits = data.draw(st.lists(st.booleans(), min_size=n * n, max_size=n * n))
    graph = tuple(tuple(j for j in range(n) if bits[i * n + j]) for i in range(n))
    ends = frozenset({n - 1})
    index, length, exact = longest_paths(graph, ends, {0: 0})
    paths = [
        (0, *rest)
        for size in range(n)
        for rest in permutations(range(1, n), size)
        if all(b in graph[a] for a, b in zip((0, *rest), rest, strict=False))
        and (n - 1) not in (0, *rest)[:-1]
    ]
    reached = {path[-1] for path in paths}
    assert exact
    assert index == {b: max(len(p) - 1 for p in paths if p[-1] == b) for b in reached}
    full = [p for p in paths if p[-1] == n - 1]
    expected = {b: max((len(p) - 1 for p in full if b in p), default=None) for b in reached}
    assert length == expected


@settings(max_examples=200, deadline=None)
@given(st.integers(2, 6), st.data())
def test_every_live_state_pays_less_than_one_and_every_discriminator_has_both_sides(
    n: int, data: st.DataObject
) -> None:
    targets = data.draw(st.lists(st.integers(0, n - 1), min_size=2 * n, max_size=2 * n))
    accepting = data.draw(st.sets(st.integers(0, n - 1), min_size=1))
    ldba = automaton(["a"], n, lambda b, true: targets[2 * b + len(true)], accepting)
    try:
        stages = stage_plan(ldba)
    except CompileError:
        return
    for b in ldba.states:
        if stages.distance[b] > 0:
            assert stages.index[b] < stages.length[b]
            assert stages.positive[b]
            assert b in stages.negative[b]
            assert not set(stages.positive[b]) & set(stages.negative[b])
