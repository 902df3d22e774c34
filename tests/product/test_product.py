import numpy as np
import pytest

from tests.plan.automata import automaton, chain, stabilization
from tests.product import worlds  # noqa: F401  # registers
from tiloilc.automaton.ldba import Ldba
from tiloilc.product import Copies, Floats, Int, Product, walk_tables
from tiloilc.spec.model import Environment


def first_option(observations: Floats, options: Int) -> Int:
    return options[:, 0]


def last_option(observations: Floats, options: Int) -> Int:
    return options[:, -1]


def product(
    ldba: Ldba, count: int = 1, choose=first_option, epsilon="free", horizon=9, **kwargs
) -> Product:
    """On `Line`: proposition i holds in cell i."""

    def labels(observations: Floats) -> Int:
        return np.left_shift(1, observations[:, 0].astype(np.int64)) & (
            (1 << len(ldba.propositions)) - 1
        )

    copies = Copies(Environment(id="TestsLine-v0", horizon=9, kwargs=kwargs), count)
    return Product(copies, labels, walk_tables(ldba, epsilon), choose, horizon)


def begin(p: Product) -> None:
    p.reset([0] * p.copies.count, np.ones(p.copies.count, dtype=np.bool_))


def test_the_label_of_the_first_state_is_read() -> None:
    p = product(chain(["zero", "one"]))  # cell 0 makes `zero` true
    begin(p)
    assert p.states.tolist() == [1]
    assert p.letters.tolist() == [1]
    assert p.elapsed.tolist() == [0]


def test_labels_are_of_the_state_arrived_in_not_of_the_one_left() -> None:
    p = product(chain(["zero", "one"]))
    begin(p)
    p.step(np.array([1]))  # stays in cell 0: `one` is not yet true
    assert p.states.tolist() == [1]
    p.step(np.array([2]))  # to cell 1
    assert p.states.tolist() == [2]
    assert p.letters.tolist() == [2]


def test_a_reset_of_some_copies_leaves_the_others_alone() -> None:
    p = product(chain(["zero", "one"]), count=2)
    begin(p)
    p.step(np.array([2, 2]))
    p.reset([0, 0], np.array([False, True]))
    assert p.observations[:, 0].tolist() == [1, 0]
    assert p.states.tolist() == [2, 1]
    assert p.letters.tolist() == [2, 1]
    assert p.elapsed.tolist() == [1, 0]


@pytest.mark.parametrize(("choose", "expected"), [(first_option, 0), (last_option, 1)])
def test_on_arrival_the_chooser_decides_about_jumps(choose, expected: int) -> None:
    p = product(stabilization(), choose=choose)  # cell 0 is yellow, cell 1 is blue
    begin(p)
    assert p.states.tolist() == [expected]


def test_a_jump_reads_the_label_of_the_same_arrival() -> None:
    p = product(stabilization(), choose=last_option, start=2)  # neither yellow nor blue
    begin(p)
    assert p.states.tolist() == [0]  # the jump would die at once, so it is not offered
    p.step(np.array([0]))  # into blue
    assert p.states.tolist() == [2]


def test_the_chooser_is_not_asked_where_there_is_no_choice() -> None:
    def never(observations: Floats, options: Int) -> Int:
        raise AssertionError

    p = product(chain(["zero"]), choose=never)
    begin(p)
    p.step(np.array([1]))


def test_the_chooser_sees_the_state_arrived_in() -> None:
    asked = []

    def choose(observations: Floats, options: Int) -> Int:
        asked.append((observations[:, 0].tolist(), options.tolist()))
        return options[:, 0]

    ldba = automaton(["p"], 2, lambda b, true: b, {1}, None, [(0, 1)])
    p = product(ldba, choose=choose)
    begin(p)
    p.step(np.array([2]))
    assert asked == [([0.0], [[0, 1]]), ([1.0], [[0, 1]])]


def test_termination_is_handed_on_and_ends_nothing_by_itself() -> None:
    p = product(chain(["zero", "one"]), count=2, size=2, ends=True)
    begin(p)
    assert p.step(np.array([2, 1])).tolist() == [True, False]
    assert p.elapsed.tolist() == [1, 1]


# jumps that take a step


def test_a_jump_that_takes_a_step_reads_no_label_and_moves_nothing() -> None:
    """Cell 0 is yellow, cell 1 blue: the jump is taken all the same, and blue is then read in 1."""
    p = product(stabilization(), choose=last_option, epsilon="step", start=3)
    begin(p)
    assert (p.landed.tolist(), p.states.tolist(), p.jumped.tolist()) == ([0], [1], [True])
    assert (p.elapsed.tolist(), p.moves.tolist()) == ([1], [0])
    assert p.observations[:, 0].tolist() == [3]
    p.step(np.array([1]))
    assert (p.landed.tolist(), p.states.tolist(), p.jumped.tolist()) == ([2], [2], [False])
    assert (p.elapsed.tolist(), p.moves.tolist()) == ([2], [1])


def test_who_does_not_jump_goes_on_as_if_there_were_no_jumps() -> None:
    p = product(stabilization(), epsilon="step", start=3)
    begin(p)
    for t in range(1, 4):
        p.step(np.array([1]))
        assert (p.states.tolist(), p.elapsed.tolist(), p.moves.tolist()) == ([0], [t], [t])


def test_nobody_jumps_when_the_time_is_over_nor_where_the_environment_has_ended() -> None:
    p = product(stabilization(), choose=last_option, epsilon="step", horizon=0, start=3)
    begin(p)
    assert (p.states.tolist(), p.elapsed.tolist()) == ([0], [0])

    def second_time(observations: Floats, options: Int) -> Int:
        return options[:, -1] if observations[0, 0] == 4 else options[:, 0]

    p = product(stabilization(), choose=second_time, epsilon="step", start=3, ends=True)
    begin(p)
    assert p.step(np.array([2])).tolist() == [True]
    assert (p.states.tolist(), p.jumped.tolist()) == ([0], [False])


def test_a_reset_of_some_copies_makes_only_those_jump() -> None:
    p = product(stabilization(), count=2, choose=first_option, epsilon="step", start=3)
    begin(p)
    p.choose = last_option
    p.reset([0, 0], np.array([False, True]))
    assert (p.states.tolist(), p.elapsed.tolist()) == ([0, 1], [0, 1])
    assert p.jumped.tolist() == [False, True]
