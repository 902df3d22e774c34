"""Exact probabilities: chains by hand, and Storm, our automata and numpy agree on random ones."""

import dataclasses
import random
from fractions import Fraction

import gymnasium as gym
import numpy as np
import pytest

from tests.evaluate.verify.worlds import LAST, PLAY, STAY, Told, gamble, markov, model
from tests.learn.examples import plan
from tests.plan.automata import stabilization
from tests.properties.models import Choice, Mdp, best_probability, buchi_probability, random_mdp
from tests.strategies import random_formula
from tiloilc.automaton import translate
from tiloilc.evaluate.verify.chain import Chain, decisions, induced_chain
from tiloilc.evaluate.verify.exact import Exact, exactly, formula_probability, maximum
from tiloilc.evaluate.verify.storm import Unanswered, fractions, storm_text
from tiloilc.ltl import parse, to_text
from tiloilc.plan import Plan
from tiloilc.product import Int, walk_tables
from tiloilc.tasks import MarkovModel, markov_model

GOAL, PIT = 1, 2
ON, SIDES = [PLAY] * 5, np.array([PIT, 0, 0, 0, GOAL])


def asked(text: str, names: tuple[str, ...] = ("goal", "pit")) -> Plan:
    formula = parse(text, names).formula
    made = plan(translate(formula, names), "TestsLine-v0", seeds=1)
    return dataclasses.replace(made, formula=to_text(formula))


def chain_of(world: MarkovModel, letters: Int, made: Plan, policy: Told) -> Chain:
    walk = walk_tables(made.ldba)
    found = decisions(policy, world, letters, walk, 1)
    return induced_chain(world, letters, walk, found.columns[0], found.arrivals[0])


def probability(text: str, actions: list[int]) -> Fraction:
    made = asked(text)
    chain = chain_of(gamble(), SIDES, made, Told(actions))
    found = exactly(chain, made)
    assert found.accepted == found.probability
    assert not found.at_least
    by_labels = formula_probability(chain, parse(text).formula, ("goal", "pit"))
    assert by_labels == found.probability
    return found.probability


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("F goal & G !pit", Fraction(9, 10)),
        ("G !pit", Fraction(9, 10)),
        ("F pit", Fraction(1, 10)),
        ("G F goal", Fraction(9, 10)),
        ("F (goal | pit)", Fraction(1)),
        ("F (goal & X F pit)", Fraction(0)),
        ("X X goal", Fraction(9, 16)),
    ],
)
def test_a_gambler_is_ruined_with_the_probability_of_the_books(
    text: str, expected: Fraction
) -> None:
    assert probability(text, ON) == expected


def test_there_is_no_time_limit_and_staying_for_ever_reaches_nothing() -> None:
    assert probability("F goal & G !pit", [STAY] * 5) == 0
    assert probability("G !pit & G !goal", [STAY] * 5) == 1


def test_the_first_letter_is_the_label_of_the_first_state() -> None:
    world = model([[[(1.0, 1)]], [[(1.0, 1)]]], [1.0, 0.0])
    for text, expected in (("goal", 1), ("pit", 0), ("X pit", 1), ("goal & X G pit", 1)):
        made = asked(text)
        chain = chain_of(world, np.array([GOAL, PIT]), made, Told([0, 0]))
        assert exactly(chain, made).probability == expected, text


def test_starts_count_by_how_likely_they_are() -> None:
    world = model([[[(1.0, 0)]], [[(1.0, 1)]], [[(1.0, 2)]]], [1 / 3, 1 / 3, 1 / 3])
    made = asked("G F goal")
    chain = chain_of(world, np.array([GOAL, PIT, GOAL]), made, Told([0, 0, 0]))
    assert exactly(chain, made).probability == Fraction(2, 3)


def test_nothing_need_lead_into_the_last_state() -> None:
    world = model([[[(1.0, 0)]], [[(0.5, 0), (0.5, 0)]]], [0.0, 1.0])
    made = asked("pit & X G goal")
    chain = chain_of(world, np.array([GOAL, PIT]), made, Told([0, 0]))
    assert chain.states.tolist() == [0, 1]
    assert exactly(chain, made).probability == 1
    assert maximum(world, np.array([GOAL, PIT]), made).probability == 1
    both = dataclasses.replace(world, initial=np.array([0.5, 0.5]))
    chain = chain_of(both, np.array([GOAL, PIT]), made, Told([0, 0]))
    assert exactly(chain, made).probability == Fraction(1, 2)
    assert maximum(both, np.array([GOAL, PIT]), made).probability == Fraction(1, 2)


def test_only_what_can_be_reached_is_in_the_chain() -> None:
    made = asked("F goal & G !pit")
    chain = chain_of(gamble(), SIDES, made, Told([STAY] * 5))
    assert (chain.states.tolist(), chain.initial.tolist()) == ([2], [1.0])
    assert len(chain_of(gamble(), SIDES, made, Told(ON)).states) == LAST + 1


def test_the_most_that_any_gambler_can_reach() -> None:
    assert maximum(gamble(), SIDES, asked("F goal & G !pit")).probability == Fraction(9, 10)
    assert maximum(gamble(), SIDES, asked("G !pit")).probability == 1
    assert maximum(gamble(), SIDES, asked("F goal & F pit")).probability == 0


def test_on_the_frozen_lake_it_is_what_is_known_of_it() -> None:
    """The optimal policy of the 4×4 lake reaches the goal with 0.8235, as value iteration says."""
    world = markov_model(gym.make("FrozenLake-v1"))
    assert world is not None
    letters = np.where(world.observations[:, 0] == 15, GOAL, 0)
    assert maximum(world, letters, asked("F goal")).probability == Fraction(14, 17)


def test_random_policies_in_random_worlds_have_one_probability() -> None:
    """By our automaton and Storm's search, by labels and Storm's translator, by numpy."""
    generator = random.Random("verify")
    between = 0
    for _ in range(200):
        names = ("a", "b", "c")
        mdp = random_mdp(generator, len(names))
        made = asked(satisfiable(generator, names), names)
        chain, _ = random_policy(mdp, made, generator)
        found = exactly(chain, made)
        assert float(found.accepted) == pytest.approx(by_numpy(chain)), made.formula
        assert found.accepted <= found.probability
        if not made.ldba.jumps:
            try:
                formula = parse(made.formula, names).formula
                assert formula_probability(chain, formula, names) == found.probability
            except Unanswered:
                continue
        between += 0 < found.probability < 1
    assert between >= 5


def satisfiable(generator: random.Random, names: tuple[str, ...]) -> str:
    while True:
        formula = random_formula(generator, names, 8)
        if translate(formula, names).accepting:
            return to_text(formula)


def random_policy(mdp: Mdp, made: Plan, generator: random.Random) -> tuple[Chain, MarkovModel]:
    world, walk = markov(mdp), walk_tables(made.ldba)
    letters = np.array(mdp.labels)
    shape = (len(letters), walk.states)
    draw = np.random.default_rng(generator.randrange(10**6))
    columns = draw.integers(world.successor.shape[1], size=shape)
    options = walk.options[np.arange(walk.states), letters[:, None]]
    which = draw.integers(walk.width, size=shape)
    arrivals = np.take_along_axis(options, which[..., None], 2)[..., 0]
    return induced_chain(world, letters, walk, columns, arrivals), world


def by_numpy(chain: Chain) -> float:
    """The probability of accepting, by the property tests' own search and solver."""
    dense = chain.edges.toarray()
    nodes = [
        [Choice(bool(accepts), {int(t): float(row[t]) for t in np.flatnonzero(row)})]
        for accepts, row in zip(chain.accepting, dense, strict=True)
    ]
    start = Choice(False, {int(i) + 1: float(chain.initial[i]) for i in chain.initial.nonzero()[0]})
    moved = [[Choice(c.marked, {t + 1: p for t, p in c.outcome.items()})] for (c,) in nodes]
    return buchi_probability([[start], *moved])


def test_no_policy_is_better_than_the_best() -> None:
    generator = random.Random("maximum")
    names = ("a", "b", "c")
    for _ in range(25):
        mdp = random_mdp(generator, len(names))
        made = asked(satisfiable(generator, names), names)
        chain, world = random_policy(mdp, made, generator)
        best = maximum(world, np.array(mdp.labels), made)
        assert float(best.probability) == pytest.approx(best_probability(mdp, made.ldba))
        assert exactly(chain, made).probability <= best.probability


def test_an_automaton_from_a_file_has_the_same_maximum_as_its_formula() -> None:
    generator = random.Random("files")
    names = ("a", "b", "c")
    for text in ("F G a | G F b", "F (a & X F b) & G !c", "F G (a | X b)"):
        for _ in range(5):
            mdp = random_mdp(generator, len(names))
            made = asked(text, names)
            told = maximum(markov(mdp), np.array(mdp.labels), made)
            alone = dataclasses.replace(made, formula="")
            assert maximum(markov(mdp), np.array(mdp.labels), alone).probability == told.probability


def lingering(option: int) -> Exact:
    """`FG y & G !b` in a world that shows y for ever; the agent jumps, or never does."""
    made = dataclasses.replace(
        plan(stabilization(), "TestsLine-v0", seeds=1), formula="F G y & G !b"
    )
    world = model([[[(1.0, 1)]], [[(1.0, 1)]]], [1.0, 0.0])
    return exactly(chain_of(world, np.array([0, 1]), made, Told([0, 0], option)), made)


def test_a_behaviour_may_satisfy_the_formula_though_its_agent_never_jumps() -> None:
    jumps, stays = lingering(-1), lingering(0)
    assert (jumps.probability, jumps.accepted) == (1, 1)
    assert (stays.probability, stays.accepted) == (1, 0)


def test_thirds_are_thirds_and_doubled_outcomes_one() -> None:
    found = fractions(np.array([2, 0, 2, 5]), np.array([1 / 3, 1 / 3, 0.33333333333333337, 0.0]))
    assert found == {0: Fraction(1, 3), 2: Fraction(2, 3)}
    assert sum(fractions(np.arange(3), np.array([0.1, 0.2, 0.7])).values()) == 1
    tiny = fractions(np.arange(2), np.array([1e-12, 1 - 1e-12]))
    assert 0 < tiny[0] < 1e-11


def test_names_of_propositions_can_be_anything() -> None:
    formula = parse('F "a b" & G !init', ("a b", "init")).formula
    assert storm_text(formula, ("a b", "init")) == '((F ("p0")) & (G (!("p1"))))'
