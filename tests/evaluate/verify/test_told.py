"""Ways to fail in words, and the paths that they are told of."""

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest

from tests.evaluate.verify.worlds import Told, gamble, model
from tests.learn.examples import plan
from tests.plan.automata import ring, stabilization
from tiloilc.automaton import translate
from tiloilc.automaton.ldba import Ldba
from tiloilc.evaluate.verify import told
from tiloilc.evaluate.verify.chain import decisions, induced_chain
from tiloilc.evaluate.verify.counterexample import Failure, failure
from tiloilc.evaluate.verify.told import Path
from tiloilc.ltl import parse
from tiloilc.plan import Plan
from tiloilc.product import walk_tables
from tiloilc.tasks import MarkovModel

CYCLE = ring(["r", "g", "y"], "b")


def made(ldba: Ldba = CYCLE) -> Plan:
    return plan(ldba, "TestsLine-v0", horizon=6, seeds=1)


def path(ldba: Ldba, words: Sequence[str], loop: int | None = None) -> Path:
    """What follows when the propositions in each of `words` hold, without jumps."""
    letters = [ldba.letter(word.split()) for word in words]
    seen = np.arange(len(letters), dtype=np.float32)[:, None]
    return Path(seen, np.array(letters), np.array(ldba.run(letters)), loop)


def test_a_violation_is_told_with_its_step_its_stage_and_what_became_true() -> None:
    fell = path(CYCLE, ["", "r", "", "g", "g b", "b"])
    assert told.violation(fell, made()) == (
        "step 4: `b` became true in stage 2: the formula can no longer be satisfied"
    )
    assert told.way(fell, made()) == [
        "step 0: stage 0",
        "step 1: `r` became true, stage 1",
        "step 3: `g` became true, stage 2",
    ]


def test_a_violation_at_the_start_has_no_way() -> None:
    fell = path(CYCLE, ["b", ""])
    assert told.violation(fell, made()).startswith("step 0: `b` is true at the start:")
    assert told.way(fell, made()) == []


def test_what_stopped_being_true_is_told() -> None:
    names = ("y",)
    ldba = translate(parse("G y", names).formula, names)
    fell = path(ldba, ["y", "y", ""])
    assert told.violation(fell, made(ldba)) == (
        "step 2: `y` became false in acceptance: the formula can no longer be satisfied"
    )


def test_a_repetition_is_told_with_what_never_happens() -> None:
    assert told.repetition(path(CYCLE, ["", "r", "", ""], 2), made(), 2) == (
        "from step 2 on it repeats 2 states for ever, in stage 1, and `g` never becomes true"
    )
    assert told.repetition(path(CYCLE, ["", "", ""], 2), made(), 1) == (
        "from step 2 on it stays in one state for ever, in stage 0, and `r` never becomes true"
    )
    assert "it stays among 7 states for ever" in told.repetition(
        path(CYCLE, ["", "", ""], 1), made(), 7
    )


def test_an_agent_that_never_decides_is_told_so() -> None:
    said = told.repetition(path(stabilization(), ["", "y"], 1), made(stabilization()), 1)
    assert said.endswith("in stage 0, without deciding that from here on `state 1` holds (ε-jump)")


def test_who_could_not_decide_is_told_what_was_missing() -> None:
    said = told.repetition(path(stabilization(), ["", ""], 1), made(stabilization()), 1)
    assert said.endswith("in stage 0, and `y & !b` never holds")
    reach = translate(parse("F G y", ("y",)).formula, ("y",))
    idle = told.shortfall(path(reach, [""] * 7), made(reach), 0, 1)
    assert idle.endswith("in stage 0 since step 0, and `y` did not become true")


def test_a_decision_is_part_of_the_way() -> None:
    ldba = stabilization()
    seen = np.zeros((3, 1), np.float32)
    letters = np.array([ldba.letter(["y"])] * 3)
    jumped = Path(seen, letters, np.array([0, 1, 1]), None)
    assert told.way(jumped, made(ldba))[1] == "step 1: decides for state 1 (ε-jump), acceptance"


def test_an_episode_that_ran_out_of_time_is_told_with_where_it_was() -> None:
    short = path(CYCLE, ["", "r", "", "", "", "", ""])
    assert told.shortfall(short, made(), 0, 1) == (
        "step 6: the horizon was over with 0 accepting visits, in stage 1 since step 1,"
        " and `g` did not become true"
    )
    ended = path(CYCLE, ["", "r", "g", "y"])
    assert told.shortfall(ended, made(), 1, 2).startswith(
        "step 3: the environment ended the episode with 1 accepting visit of 2, in acceptance"
    )


def test_of_a_long_way_the_beginning_and_the_end_are_told() -> None:
    laps = path(CYCLE, ["", *["r", "g", "y"] * 20])
    lines = told.way(laps, made())
    assert len(lines) == told.MOST_LINES + 1
    assert lines[0] == "step 0: stage 0"
    assert lines[6] == "… 49 more …"
    assert lines[-1] == "step 60: `y` became true, acceptance"


def failing(
    world: MarkovModel, letters: list[int], ldba: Ldba, policy: Told, formula: str = ""
) -> Failure | None:
    task = dataclasses.replace(made(ldba), formula=formula)
    walk = walk_tables(ldba)
    found = decisions(policy, world, np.array(letters), walk, 1)
    chain = induced_chain(world, np.array(letters), walk, found.columns[0], found.arrivals[0])
    return failure(chain, world, task)


SIDES = [2, 0, 0, 0, 1]
REACH = translate(parse("F goal & G !pit", ("goal", "pit")).formula, ("goal", "pit"))


def test_the_likeliest_way_into_ruin_is_found() -> None:
    found = failing(gamble(), SIDES, REACH, Told([1] * 5))
    assert found is not None
    assert found.path.observations[:, 0].tolist() == [2, 1, 0]
    assert (found.probability, found.path.lost(REACH)) == (pytest.approx(1 / 16), 2)


def test_who_stays_is_shown_where_it_stays() -> None:
    found = failing(gamble(), SIDES, REACH, Told([0] * 5))
    assert found is not None
    assert (found.path.observations[:, 0].tolist(), found.path.loop) == ([2], 0)
    assert (found.probability, found.nodes) == (pytest.approx(1), 1)


def test_who_cannot_fail_has_no_counterexample() -> None:
    always = translate(parse("F (goal | pit)", ("goal", "pit")).formula, ("goal", "pit"))
    assert failing(gamble(), SIDES, always, Told([1] * 5)) is None


def test_a_loop_is_followed_once_around() -> None:
    world = model([[[(1.0, 1)]], [[(1.0, 2)]], [[(1.0, 3)]], [[(1.0, 1)]]], [1.0, 0, 0, 0])
    found = failing(world, [0, 0, 0, 0], REACH, Told([0] * 4))
    assert found is not None
    assert found.path.observations[:, 0].tolist() == [0, 1, 2, 3]
    assert (found.path.loop, found.nodes) == (1, 3)


def test_a_behaviour_that_satisfies_the_formula_is_no_counterexample() -> None:
    """The agent never jumps: y holds for ever or not, as the dice fall."""
    world = model([[[(0.75, 1), (0.25, 2)]], [[(1.0, 1)]], [[(1.0, 2)]]], [1.0, 0, 0])
    found = failing(world, [0, 1, 0], stabilization(), Told([0] * 3), "F G y & G !b")
    assert found is not None
    assert found.path.observations[:, 0].tolist() == [0, 2]
    assert found.probability == pytest.approx(0.25)
