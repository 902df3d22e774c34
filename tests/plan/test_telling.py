"""What is told of states is true: every claim checked on runs of random automata."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence

import pytest

from tests.automaton.formulas import PAPER
from tests.plan.automata import flatworld_cycle, stabilization
from tests.strategies import random_formula
from tiloilc.automaton import Ldba, translate
from tiloilc.diag import CompileError
from tiloilc.ltl import Lasso, holds, parse, to_text
from tiloilc.plan import Stages, stage_plan
from tiloilc.plan.sentences import decision_lines, in_a_row, sentence, stage_lines
from tiloilc.plan.telling import Teller

ABC = ("a", "b", "c")


def planned(text: str, propositions: Sequence[str] | None = None) -> tuple[Ldba, Stages]:
    parsed = parse(text, propositions)
    ldba = translate(parsed.formula, parsed.propositions)
    return ldba, stage_plan(ldba)


def some() -> Iterator[tuple[Ldba, Stages]]:
    """Automata of random formulas, a good part of which need jumps, and those of the paper."""
    generator = random.Random("telling")
    shapes = (
        "{0}",
        "F G ({0}) | {1}",
        "G F ({0}) & ({1})",
        "F ({0} & X F ({1}))",
        "G ({0} -> F {1})",
    )
    for _ in range(260):
        parts = [to_text(random_formula(generator, ABC, 5)) for _ in range(2)]
        try:
            ldba, stages = planned(generator.choice(shapes).format(*parts), ABC)
        except CompileError:  # nothing is ever accepted
            continue
        if len(ldba.names) < 20:
            yield ldba, stages
    for known in PAPER.values():
        yield planned(known.text)
    for ldba in (flatworld_cycle(), stabilization()):
        yield ldba, stage_plan(ldba)


SOME = list(some())


def true_of(guard: str, letter: int, propositions: Sequence[str]) -> bool:
    formula = parse(guard, propositions).formula
    return holds(formula, Lasso((letter,), (0,)), propositions)


def letters(ldba: Ldba) -> range:
    return range(1 << min(len(ldba.propositions), 6))


def live(ldba: Ldba) -> list[int]:
    return [b for b in ldba.states if b != ldba.sink]


def runs(
    ldba: Ldba, generator: random.Random, count: int = 30, steps: int = 12
) -> Iterator[tuple[list[int], list[int]]]:
    """Random runs, by jumps too: letters, and the states before the first and after each."""
    for _ in range(count):
        states, read = [ldba.initial], []
        for _ in range(steps):
            letter = generator.randrange(1 << len(ldba.propositions))
            state = generator.choice(ldba.options(states[-1], letter))
            if state == ldba.sink:
                break
            read.append(letter)
            states.append(state)
        yield read, states


def test_there_are_enough_automata_with_and_without_jumps() -> None:
    assert len(SOME) > 150
    assert sum(bool(ldba.jumps) for ldba, _ in SOME) > 25


def test_the_first_row_whose_guard_holds_says_where_a_letter_leads() -> None:
    for ldba, stages in SOME:
        teller = Teller(ldba, stages)
        for b in live(ldba):
            cases = teller.cases(b)
            for letter in letters(ldba):
                for case in cases:
                    if case.guard == "else" or true_of(case.guard, letter, ldba.propositions):
                        assert case.target == ldba.successor(b, letter)
                        break
                else:
                    raise AssertionError(f"no row for {letter}")


def test_what_loses_for_ever_leads_to_the_sink_whatever_is_decided() -> None:
    for ldba, stages in SOME:
        teller = Teller(ldba, stages)
        for b in live(ldba):
            loses = teller.loses(b)
            for letter in letters(ldba):
                lost = ldba.options(b, letter) == (ldba.sink,)
                assert lost == bool(loses and true_of(loses, letter, ldba.propositions))


def test_what_was_seen_was_read_in_this_order() -> None:
    generator = random.Random("seen")
    told = 0
    for ldba, stages in SOME:
        teller = Teller(ldba, stages)
        seen = {b: teller.seen(b) for b in live(ldba)}
        for read, states in runs(ldba, generator):
            for place, b in enumerate(states):
                at = 0
                for guard in seen[b]:
                    while at < place and not true_of(guard, read[at], ldba.propositions):
                        at += 1
                    assert at < place, f"{guard} was not seen before {b}"
                    at += 1
                    told += 1
    assert told > 1000


def test_what_must_be_reached_is_read_before_anything_is_accepted() -> None:
    generator = random.Random("needs")
    told = 0
    for ldba, stages in SOME:
        teller = Teller(ldba, stages)
        needs = {b: teller.needs(b) for b in live(ldba)}
        assert not any(needs[b] for b in ldba.accepting)
        for read, states in runs(ldba, generator):
            for start, b in enumerate(states):
                if not needs[b] or not ldba.accepting & set(states[start:]):
                    continue
                stop = next(i for i in range(start, len(states)) if states[i] in ldba.accepting)
                leaving = [read[i] for i in range(start, stop) if states[i] == b]
                assert any(true_of(needs[b], letter, ldba.propositions) for letter in leaving)
                told += 1
    assert told > 1000


def test_whoever_must_decide_is_never_accepted_without_a_jump() -> None:
    told = 0
    for ldba, stages in SOME:
        teller = Teller(ldba, stages)
        for b in live(ldba):
            if teller.must_decide(b):
                told += 1
                reached, work = {b}, [b]
                while work:
                    c = work.pop()
                    readers = (c,) if c == b else (c, *ldba.jump_targets[c])
                    follow = {e.target for reader in readers for e in ldba.outgoing[reader]}
                    work += sorted(follow - reached)
                    reached |= follow
                assert not reached & ldba.accepting
    assert told > 10


def test_decided_are_the_jumps_that_every_way_takes() -> None:
    generator = random.Random("decided")
    told = 0
    for ldba, stages in SOME:
        if not ldba.jumps:
            continue
        teller = Teller(ldba, stages)
        decided = {b: teller.decided(b) for b in live(ldba)}
        for read, states in runs(ldba, generator):
            taken: set[int] = set()
            for letter, before, after in zip(read, states, states[1:], strict=False):
                if after != ldba.successor(before, letter):
                    jumps = ldba.jump_targets[before]
                    taken |= {j for j in jumps if ldba.successor(j, letter) == after}
                assert set(decided[after]) <= taken
                told += len(decided[after])
    assert told > 100


def test_done_and_safe_are_said_only_where_that_is_so() -> None:
    for ldba, stages in SOME:
        teller = Teller(ldba, stages)
        for b in live(ldba):
            reached, work = {b}, [b]
            while work:
                c = work.pop()
                follow = {s for letter in letters(ldba) for s in ldba.options(c, letter)}
                work += sorted(follow - reached)
                reached |= follow
            said = sentence(teller, b)
            only = reached - {ldba.sink} <= ldba.accepting
            assert ("whatever comes is accepted" in said) <= (only and ldba.sink not in reached)
            assert ("as long as nothing is lost" in said) <= only


def test_the_rows_of_a_decision_are_those_of_the_jump() -> None:
    for ldba, stages in SOME:
        teller = Teller(ldba, stages)
        for b in live(ldba):
            for decision in teller.decisions(b):
                for letter in letters(ldba):
                    target = ldba.successor(decision.jump, letter)
                    fits = [t for g, t in decision.ways if true_of(g, letter, ldba.propositions)]
                    assert fits == ([] if target == ldba.sink else [target])


def test_a_stage_is_told_in_words() -> None:
    ldba, stages = planned("G F (r & X F (g & X F y)) & G !b")
    lines = list(stage_lines(ldba, stages))
    assert lines[6:12] == [
        "stage 1 of 3: state 1",
        "  the agent has seen r and must now reach g; touching b loses for ever",
        "  left to do: F (g & X F y) & G F (r & X F (g & X F y)) & G !b",
        "    b       is lost for ever",
        "    else g  leads on to state 2 (stage 2)",
        "    else    stays",
    ]


@pytest.mark.parametrize(
    ("text", "state", "told"),
    [
        (
            "F (a & X F b)",
            2,
            "the agent has seen a, then b; all is done: whatever comes is accepted",
        ),
        ("G a", 0, "this is accepting for as long as nothing is lost; !a loses for ever"),
        ("X X a", 0, "the agent goes on with any letter"),
        ("F a & G !z", 0, "the agent must reach a; touching z loses for ever"),
        ("F (a | b)", 0, "the agent must reach a or b"),
        (
            "F G y & G !b",
            0,
            "the agent must at some time decide for state 1; touching b loses for ever",
        ),
        (
            "F G y & G !b",
            1,
            "the agent has decided for state 1 and seen y; this is accepting for as long as nothing"
            " is lost; !y | b loses for ever",
        ),
        ("G F (a & X b)", 1, "the agent has seen a and must now reach b"),
    ],
)
def test_sentences(text: str, state: int, told: str) -> None:
    assert sentence(Teller(*planned(text)), state) == told


def test_a_jump_is_told_as_a_decision() -> None:
    (line,) = decision_lines(Teller(*planned("F G y & G !b")), 0)
    assert line == (
        "or decide for state 1, that from here on G y & G !b (ε-jump):"
        " y & !b leads to state 1 (stage 1, accepting)"
    )


def test_names_of_states_are_not_taken_for_what_is_left_to_do_unless_they_are() -> None:
    ldba = stabilization()
    lines = list(stage_lines(ldba, stage_plan(ldba), meant=False))
    assert "  named: state 0" in lines
    assert not any("left to do" in line or "from here on" in line for line in lines)


def test_names_in_a_row() -> None:
    assert in_a_row(["0"]) == "0"
    assert in_a_row(["0", "1", "a violation"]) == "0, 1 or a violation"
