"""Translation: shapes, sizes and order of known automata, and what every automaton must have."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from tests.automaton.formulas import PAPER
from tests.strategies import random_formula, random_lasso
from tiloilc.automaton import Ldba, accepts, guard_text, is_empty, rejected_word, translate
from tiloilc.diag import CompileError
from tiloilc.ltl import holds, parse, to_text
from tiloilc.ltl.ast import Formula, Next, Proposition

ROOT = Path(__file__).parents[2]
ABC = ("a", "b", "c")


def automaton(text: str, **options: object) -> Ldba:
    parsed = parse(text)
    return translate(parsed.formula, parsed.propositions, **options)  # type: ignore[arg-type]


def live(ldba: Ldba) -> int:
    return len(ldba.names) - (ldba.sink is not None)


@pytest.mark.parametrize("name", PAPER)
def test_the_papers_formulas_have_the_best_known_sizes(name: str) -> None:
    known = PAPER[name]
    assert live(automaton(known.text, acceptance="edge")) == known.edge
    ldba = automaton(known.text)
    assert live(ldba) == known.state
    assert len(ldba.jumps) == known.jumps


def test_a_cycle_goes_round_in_the_written_order_and_accepts_at_its_end() -> None:
    ldba = automaton("G F (a & X F (b & X F c)) & G !z")
    a, b, c, z = (ldba.letter([name]) for name in "abcz")
    assert ldba.run([a, b, c]) == [1, 2, 3]
    assert ldba.accepting == {3}
    assert ldba.run([b, c, 0]) == [0, 0, 0]
    assert [ldba.successor(q, z) for q in range(4)] == [ldba.sink] * 4
    for letter in range(16):
        assert ldba.successor(3, letter) == ldba.successor(0, letter)


@pytest.mark.parametrize("length", [2, 3, 4, 5, 6])
def test_a_cycle_of_n_propositions_has_n_plus_one_states(length: int) -> None:
    names = "abcdef"[:length]
    text = names[-1]
    for name in reversed(names[:-1]):
        text = f"{name} & X F ({text})"
    assert live(automaton(f"G F ({text}) & G !z")) == length + 1


def test_the_next_place_must_be_visited_strictly_later() -> None:
    ldba = automaton("G F (a & X F (b & X F c))")
    everything = ldba.letter("abc")
    assert ldba.run([everything] * 4) == [1, 2, 3, 1]


def test_goals_are_served_in_the_written_order() -> None:
    ldba = automaton("G F b & G F a")
    a, b = ldba.letter("a"), ldba.letter("b")
    assert ldba.run([a, b, a]) == [0, 1, 2]
    assert ldba.successor(0, a | b) == 2, "one letter may serve both"


def test_staying_for_ever_is_a_jump() -> None:
    ldba = automaton("F G y & G !b")
    y, b = ldba.letter("y"), ldba.letter("b")
    assert (ldba.jumps, ldba.accepting, ldba.sink) == (((0, 1),), {1}, 2)
    assert ldba.options(0, y) == (0, 1)
    assert ldba.options(0, 0) == (0,), "nobody jumps into the sink"
    assert ldba.options(1, 0) == (2,)
    assert ldba.options(0, b) == (2,)


@pytest.mark.parametrize(
    ("text", "states"),
    [
        ("G F a", 2),
        ("F a", 2),
        ("G a", 1),
        ("G (a -> F b)", 2),
        ("G F a | F b", 3),
        ("F a | G b", 3),
        ("a U b", 2),
        ("X X a", 4),
        ("F (a & G F b)", 3),
        ("G (a -> X b)", 2),
        ("(a | G F b) & G !c", 5),
    ],
)
def test_the_recurrence_class_needs_no_jumps(text: str, states: int) -> None:
    ldba = automaton(text)
    assert not ldba.jumps
    assert live(ldba) <= states


def test_of_a_safety_formula_every_live_state_on_a_cycle_accepts() -> None:
    ldba = automaton("G (a -> X !a)")
    assert ldba.accepting == set(range(live(ldba)))


def test_of_a_cosafety_formula_one_absorbing_state_accepts() -> None:
    ldba = automaton("F (a & X F b)")
    (accepting,) = ldba.accepting
    assert ldba.sink is None
    assert {ldba.successor(accepting, letter) for letter in range(4)} == {accepting}


def test_what_can_no_longer_accept_is_one_sink() -> None:
    ldba = automaton("G !z & F a & (b -> G F (c & X (!c & z)))")
    assert ldba.sink is not None
    (edge,) = ldba.outgoing[ldba.sink]
    assert edge.target == ldba.sink
    assert ldba.successor(0, ldba.letter("b")) == ldba.sink


def test_true_and_false_are_one_state_each() -> None:
    true, false = automaton("true"), automaton("F a & G !a")
    assert (true.accepting, true.sink, len(true.names)) == ({0}, None, 1)
    assert (false.accepting, false.sink, len(false.names)) == (set(), 0, 1)


def test_the_alphabet_may_have_more_propositions_than_the_formula() -> None:
    names = [f"p{i}" for i in range(40)]
    ldba = translate(parse("F p39 & G !p0").formula, names)
    assert len(ldba.names) == 3
    assert guard_text(ldba.outgoing[1][0].guard, names) == "!p0"


def test_a_mark_on_no_cycle_is_dropped() -> None:
    ldba = automaton("a & X (b & X G c)")
    assert len(ldba.accepting) == 1


def test_guards_of_a_state_part_the_letters_and_every_state_is_reached() -> None:
    generator = random.Random("shape")
    for _ in range(150):
        ldba = translate(random_formula(generator, ABC, 12), ABC)
        for state in ldba.states:
            for letter in range(8):
                hits = [e for e in ldba.outgoing[state] if any(letter in c for c in e.guard)]
                assert len(hits) == 1
        found = {ldba.initial}
        work = [ldba.initial]
        while work:
            state = work.pop()
            for target in [e.target for e in ldba.outgoing[state]] + [*ldba.jump_targets[state]]:
                if target not in found:
                    found.add(target)
                    work.append(target)
        assert found == set(ldba.states)
        assert all(target not in {s for s, _ in ldba.jumps} for _, target in ldba.jumps)


def test_states_are_numbered_breadth_first_with_the_sink_last() -> None:
    generator = random.Random("numbers")
    for _ in range(150):
        ldba = translate(random_formula(generator, ABC, 12), ABC)
        order = [ldba.initial]
        for state in order:
            reached = [ldba.successor(state, letter) for letter in range(8)]
            for target in (*reached, *ldba.jump_targets[state]):
                if target not in order and target != ldba.sink:
                    order.append(target)
        assert order == [q for q in ldba.states if q != ldba.sink] or ldba.initial == ldba.sink
        assert ldba.sink in (None, len(ldba.names) - 1)


def test_a_states_name_is_its_language() -> None:
    generator = random.Random("names")
    for _ in range(60):
        ldba = translate(random_formula(generator, ABC, 9), ABC)
        for state in ldba.states:
            parsed = parse(ldba.names[state], ABC)
            for _ in range(6):
                lasso = random_lasso(generator, ABC, 3, 3)
                moved = Ldba(**{**_fields(ldba), "initial": state})
                assert accepts(moved, lasso) == holds(parsed.formula, lasso, ABC)


def _fields(ldba: Ldba) -> dict[str, object]:
    return {name: getattr(ldba, name) for name in Ldba.__dataclass_fields__}


def test_names_say_what_is_left_to_do() -> None:
    assert automaton("F (a & X F b) & G !z").names == (
        "F (a & X F b) & G !z",
        "F b & G !z",
        "G !z",
        "false",
    )


BOMBS = [
    "G (F a & (b U X X X X X X X X X (c W X X X X X X X X a)))",
    " & ".join(f"G (a{i} -> X X X X F b{i})" for i in range(9)),
    " & ".join(f"(G F a{i} -> G F b{i})" for i in range(9)),
    "G (a -> X X X X X X X X X X X X X X X X b)",
    "F (a & X X X X X X X X X X X X X X X X X X b)",
    " & ".join(f"F (a{i} & X F b{i})" for i in range(10)),
]


@pytest.mark.parametrize("text", BOMBS, ids=range(len(BOMBS)))
def test_a_formula_bomb_ends_in_an_automaton_or_in_aut305_within_the_limits(text: str) -> None:
    parsed = parse(text)
    size, codes = 0, ["AUT305"]
    try:
        size = len(translate(parsed.formula, parsed.propositions, max_states=400, timeout=2).names)
    except CompileError as error:
        codes = [diagnostic.code for diagnostic in error.diagnostics]
    assert codes == ["AUT305"]
    assert size <= 802


def test_operators_nested_too_deeply_are_an_error_and_no_crash() -> None:
    deep: Formula = Proposition("a")
    for _ in range(20_000):
        deep = Next(deep)
    with pytest.raises(CompileError, match="AUT305"):
        translate(deep, ["a"])


def test_the_cap_on_states_is_an_error_that_names_it() -> None:
    with pytest.raises(CompileError, match="more than 3 states"):
        automaton("F (a & X F (b & X F (c & X F d)))", max_states=3)


def test_many_goals_at_once_stay_linear() -> None:
    assert live(automaton(" & ".join(f"G F a{i}" for i in range(12)))) == 13


@pytest.mark.parametrize("text", ["G F (a & X F (b & X F c)) & G !z", "(F G a | G F b) & (c W d)"])
def test_the_same_formula_gives_the_same_bytes_under_any_hash_seed(text: str) -> None:
    program = (
        "import sys; from tiloilc.ltl import parse; from tiloilc.automaton import *\n"
        "p = parse(sys.argv[1]); a = translate(p.formula, p.propositions)\n"
        "print(a, to_hoa(a), to_dot(a), to_mermaid(a), to_svg(a))"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", program, text],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            check=True,
            timeout=120,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(outputs) == 1


def test_an_unsatisfiable_formula_is_empty_and_a_valid_one_rejects_nothing() -> None:
    assert is_empty(automaton("G F a & F G !a"))
    assert rejected_word(automaton("G F a | F G !a")) is None
    assert not is_empty(automaton("G F a")), to_text(parse("G F a").formula)
