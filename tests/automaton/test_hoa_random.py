"""Random automata read back: the same words, whatever form they were written in."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction

import pytest

from tests.automaton.hoa_random import random_automaton
from tests.automaton.hoa_reader import read_hoa as read_strictly
from tests.properties.models import Mdp, best_probability, random_mdp
from tests.strategies import random_lasso
from tiloilc.automaton import Acceptance, Ldba, accepts, from_hoa, to_hoa
from tiloilc.automaton.bdd import Diagrams
from tiloilc.automaton.finish import state_based
from tiloilc.automaton.hoa.body import Body
from tiloilc.automaton.hoa.general import limited
from tiloilc.automaton.hoa.header import read_header
from tiloilc.automaton.hoa.subsets import with_subsets
from tiloilc.automaton.hoa.tokens import Tokens
from tiloilc.automaton.limits import Budget
from tiloilc.ltl import Lasso


@pytest.mark.parametrize("acceptance", ["state", "edge"])
def test_a_read_automaton_accepts_the_words_of_the_written_one(acceptance: Acceptance) -> None:
    compare(random.Random(f"read {acceptance}"), 400, acceptance)


@pytest.mark.slow
@pytest.mark.parametrize("acceptance", ["state", "edge"])
def test_many_read_automata_accept_the_words_of_the_written_ones(acceptance: Acceptance) -> None:
    compare(random.Random(f"many {acceptance}"), 6_000, acceptance)


def compare(generator: random.Random, count: int, acceptance: Acceptance) -> None:
    accepted = jumping = 0
    for _ in range(count):
        automaton, text = random_automaton(generator)
        names = generator.sample(("d", *automaton.propositions), len(automaton.propositions) + 1)
        ldba = from_hoa(text, names, acceptance=acceptance)
        check_form(ldba)
        small = len(ldba.names) <= 8  # the strict reader takes its time
        again = read_strictly(to_hoa(ldba)) if small else None
        jumping += bool(ldba.jumps)
        for _ in range(6):
            lasso = random_lasso(generator, automaton.propositions, 3, 3)
            expected = automaton.accepts(lasso)
            accepted += expected
            for wide in (0, 1 << names.index("d")):
                word = lasso_over(lasso, automaton.propositions, names, wide)
                assert accepts(ldba, word) == expected, f"{lasso}\n{text}"
                assert again is None or again.accepts(word) == expected
    assert accepted > count
    assert jumping > count // 10


def check_form(ldba: Ldba) -> None:
    """What every `Ldba` promises."""
    size = 1 << len(ldba.propositions)
    for b in ldba.states:
        row = [[x for x in range(size) if any(x in c for c in e.guard)] for e in ldba.outgoing[b]]
        assert sorted(x for letters in row for x in letters) == list(range(size))
    assert ldba.initial == 0
    assert ldba.sink in (None, len(ldba.names) - 1)
    assert not ldba.accepting or not ldba.accepting_edges
    assert not {s for s, _ in ldba.jumps} & {t for _, t in ldba.jumps}
    reached, work = {0}, [0]
    while work:
        b = work.pop()
        for t in (*(e.target for e in ldba.outgoing[b]), *ldba.jump_targets[b]):
            if t not in reached:
                reached.add(t)
                work.append(t)
    assert reached | {ldba.sink} >= set(ldba.states)


def lasso_over(lasso: Lasso, old: Sequence[str], new: Sequence[str], more: int) -> Lasso:
    """The word with its propositions in another order, and `more` true at the first position."""
    bits = [new.index(name) for name in old]

    def letter(x: int) -> int:
        return sum(1 << bit for i, bit in enumerate(bits) if x >> i & 1)

    stem = tuple(letter(x) for x in (*lasso.stem, *lasso.loop))
    return Lasso((stem[0] | more, *stem[1:]), tuple(letter(x) for x in lasso.loop))


def test_waiting_with_all_possibilities_accepts_the_same_words() -> None:
    generator = random.Random("subsets")
    for _ in range(300):
        automaton, text = random_automaton(generator)
        ldba = by_subsets(text)
        check_form(ldba)
        for _ in range(6):
            lasso = random_lasso(generator, automaton.propositions, 3, 3)
            assert accepts(ldba, lasso) == automaton.accepts(lasso), f"{lasso}\n{text}"


def by_subsets(text: str) -> Ldba:
    """The automaton read with sets of states for all that wait."""
    diagrams = Diagrams(Budget())
    tokens = Tokens(text, "<hoa>", diagrams.budget)
    body = Body(tokens, read_header(tokens, diagrams, None), diagrams)
    found = limited(body)
    if found is None:
        return from_hoa(text)
    names = tuple(map(str, found.origin))
    return state_based(with_subsets(found, names, diagrams), body.header.propositions, diagrams)


@pytest.mark.parametrize(
    "count", [150, pytest.param(2_000, marks=pytest.mark.slow)], ids=["some", "many"]
)
def test_nobody_is_made_to_guess_too_early_whatever_the_file_says(count: int) -> None:
    generator = random.Random(f"models {count}")
    between = committing = 0
    while count:
        automaton, text = random_automaton(generator, free=2, fixed=3)
        ldba, waiting = from_hoa(text), by_subsets(text)
        if not waiting.jumps:
            continue
        count -= 1
        for _ in range(5):
            mdp = random_mdp(generator, len(automaton.propositions))
            best = best_probability(mdp, waiting)
            assert best_probability(mdp, ldba) == pytest.approx(best, abs=1e-9), text
            between += 0 < best < 1
        committing += len(ldba.names) > automaton.states + 1
    assert between > 20
    assert committing > 5


EARLY = """HOA: v1
AP: 1 "a"
Start: 0
Acceptance: 1 Inf(0)
--BODY--
State: 0
[t] 1
[t] 2
State: 1
[0] 3
State: 2
[!0] 3
State: 3 {0}
[t] 3
--END--
"""


def test_a_file_that_guesses_the_next_letter_is_read_as_one_that_waits() -> None:
    half = Fraction(1, 2)
    mdp = Mdp((0, 0, 1), (({1: half, 2: half},), ({1: Fraction(1)},), ({2: Fraction(1)},)))
    assert best_probability(mdp, from_hoa(EARLY)) == 1
