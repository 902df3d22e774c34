from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.demos.examples import chain, staying
from tests.plan.automata import fork
from tiloilc.automaton.ldba import Ldba
from tiloilc.demos import (
    Demo,
    DemoSet,
    best_run,
    check_replays,
    check_shape,
    is_needed,
    replay,
    replay_all,
)
from tiloilc.product import walk_tables

CYCLE = chain("rgy", cyclic=True, avoid="b")
ONCE = chain("ab", cyclic=False, avoid="z")


def spelled(letters: list[int]) -> np.ndarray:
    """A demonstration that shows its letters."""
    return np.array(letters, np.float32)[:, None]


def read(observations: np.ndarray) -> np.ndarray:
    return observations[:, 0].astype(np.int64)


def test_the_first_label_is_read_before_the_first_step() -> None:
    run = replay(spelled([1, 2, 4]), read, CYCLE)
    assert run.states.tolist() == [1, 2, 3]
    assert run.letters.tolist() == [1, 2, 4]
    assert run.visits == 1


def test_an_accepting_first_state_is_not_a_visit() -> None:
    assert replay(spelled([1, 1, 1]), read, chain("a", cyclic=False)).visits == 2


def test_a_demonstration_is_cut_after_the_wanted_visits() -> None:
    lap = [1, 2, 4, 0]
    run = replay(spelled([0, *lap, *lap, *lap]), read, CYCLE, max_visits=2)
    assert run.visits == 2
    assert run.states.tolist() == [0, 1, 2, 3, 0, 1, 2, 3]


def test_a_demonstration_with_fewer_visits_stays_whole() -> None:
    assert len(replay(spelled([0, 1, 2, 4, 0]), read, CYCLE, max_visits=2).states) == 5


def test_a_violation_is_found_where_it_happens() -> None:
    run = replay(spelled([0, 1, 8, 0]), read, CYCLE)
    assert run.violates_at == 2
    assert run.states.tolist() == [0, 1, 4, 4]


def test_a_jump_is_taken_when_staying_begins_for_good() -> None:
    run = replay(spelled([0, 1, 0, 1, 1, 1]), read, staying())
    assert run.states.tolist() == [0, 0, 0, 1, 1, 1]
    assert run.visits == 3


@pytest.mark.parametrize(
    ("letters", "states"),
    [([0, 0, 2, 0], [2, 2, 4, 2]), ([1, 0, 2, 1], [3, 1, 1, 3]), ([0, 0, 0], [0, 0, 0])],
)
def test_of_two_promises_the_one_that_is_kept_most_often_is_made_at_once(
    letters: list[int], states: list[int]
) -> None:
    """`GF a | GF b`; who keeps none makes none."""
    assert replay(spelled(letters), read, fork()).states.tolist() == states


def test_no_jump_is_taken_into_a_violation() -> None:
    run = replay(spelled([0, 1, 1, 1, 0]), read, staying())
    assert run.states.tolist() == [0, 0, 0, 0, 0]
    assert run.violates_at is None


def test_a_violation_that_cannot_be_avoided_comes_as_late_as_it_can() -> None:
    run = replay(spelled([1, 1, 2]), read, staying())
    assert run.violates_at == 2
    assert run.visits == 1, "and before it as much is accepted as can be"


def every_run(letters: list[int], ldba: Ldba) -> list[tuple[int, ...]]:
    runs: list[tuple[int, ...]] = [()]
    for letter in letters:
        runs = [
            (*run, o)
            for run in runs
            for o in ldba.options(run[-1] if run else ldba.initial, letter)
        ]
    return runs


@given(st.lists(st.integers(0, 3), min_size=1, max_size=9))
def test_the_best_run_is_the_best_of_all_runs(letters: list[int]) -> None:
    ldba = staying()

    def worth(run: tuple[int, ...]) -> tuple[int, int]:
        return sum(b != ldba.sink for b in run), sum(b in ldba.accepting for b in run)

    runs = every_run(letters, ldba)
    ours = tuple(best_run(letters, ldba).tolist())
    assert ours in runs
    assert worth(ours) == max(worth(run) for run in runs)


def test_without_jumps_the_replay_is_the_automatons_run() -> None:
    for letters in product((0, 1, 2, 4, 8), repeat=4):
        assert best_run(letters, CYCLE).tolist() == CYCLE.run(letters)


def test_a_set_is_cut_with_its_actions() -> None:
    taken = np.arange(8)[:, None]
    demos = DemoSet((Demo(spelled([0, 1, 2, 4, 0, 1, 2, 4, 0]), taken),), {"steps": [8]})
    cut, replays = replay_all(demos, read, CYCLE, max_visits=1)
    assert cut.episodes[0].steps == 3
    assert cut.episodes[0].actions is not None
    assert cut.episodes[0].actions.tolist() == [[0], [1], [2]]
    assert cut.meta["steps"] == [3]
    assert replays[0].visits == 1


def test_a_demonstration_is_read_by_the_jumps_of_the_product_that_is_trained_in() -> None:
    """Free, the jump reads the first letter of the stay; as a step, it comes before that letter."""
    word = spelled([0, 0, 0, 1, 1, 1])
    walk = walk_tables(staying(), "step")
    step = replay(word, read, staying(), options=lambda b, x: walk.options[b, x].tolist())
    assert replay(word, read, staying()).states.tolist() == [0, 0, 0, 1, 1, 1]
    assert step.states.tolist() == [0, 0, 1, 1, 1, 1]


def findings(episodes: list[list[int]], ldba: Ldba) -> list[tuple[str, str]]:
    replays = [replay(spelled(letters), read, ldba) for letters in episodes]
    return [(d.code, d.message) for d in check_replays(replays, ldba)]


def test_good_demonstrations_have_no_findings() -> None:
    assert findings([[0, 1, 2, 4], [1, 2, 4]], CYCLE) == []
    assert findings([[0, 0, 1, 1]], staying()) == []


def test_a_proposition_that_is_never_shown_is_named() -> None:
    found = findings([[0, 1, 2, 0]], CYCLE)
    assert ("DEMO501", "no demonstration makes `y` true") in found
    assert not any("`b`" in message for _, message in found), "b is to be avoided"


def test_the_stage_that_none_leaves_is_named() -> None:
    assert ("DEMO502", "no demonstration leaves stage 1") in findings([[0, 1], [0]], ONCE)
    assert not any(code == "DEMO502" for code, _ in findings([[0, 1], [1, 2]], ONCE))


def test_falling_into_the_sink_is_no_way_to_leave_a_stage() -> None:
    codes = [code for code, _ in findings([[0, 1, 4]], ONCE)]
    assert codes == ["DEMO501", "DEMO502", "DEMO503"]


def test_a_violating_demonstration_is_named_with_its_step() -> None:
    found = findings([[1, 2], [0, 4]], ONCE)
    assert found == [("DEMO503", "demonstration 1 violates the formula at step 1")]


def test_components_are_compared_with_the_environments() -> None:
    demos = DemoSet((Demo(spelled([0])),))
    assert check_shape(demos, 1) == []
    (finding,) = check_shape(demos, 3)
    assert finding.code == "DEMO504"
    assert "demonstrations have 1 component, " in finding.message


@pytest.mark.parametrize(
    ("ldba", "needed"),
    [(CYCLE, "rgy"), (ONCE, "ab"), (staying(), "y"), (chain("a", cyclic=False), "a")],
)
def test_needed_is_what_nothing_is_accepted_without(ldba: Ldba, needed: str) -> None:
    assert needed == "".join(name for i, name in enumerate(ldba.propositions) if is_needed(ldba, i))
