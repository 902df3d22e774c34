from itertools import product

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.plan.automata import automaton, chain, flatworld_cycle, stabilization
from tests.strategies import formulas, lassos
from tiloilc.automaton import accepts, translate
from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import CompileError
from tiloilc.ltl import Lasso, parse
from tiloilc.ltl.ast import Formula
from tiloilc.product import walk_tables
from tiloilc.product.walk import MAX_PROPOSITIONS


@st.composite
def automata(draw: st.DrawFn) -> Ldba:
    """Any complete automaton with up to 5 states, 3 propositions, a sink and jumps perhaps."""
    states = draw(st.integers(1, 5))
    names = ["p", "q", "r"][: draw(st.integers(0, 3))]
    sink = states - 1 if states > 1 and draw(st.booleans()) else None
    table = draw(
        st.lists(
            st.lists(st.integers(0, states - 1), min_size=8, max_size=8),
            min_size=states,
            max_size=states,
        )
    )
    live = [b for b in range(states) if b != sink]
    pairs = st.tuples(st.sampled_from(live), st.sampled_from(live))
    jumps = draw(st.lists(pairs.filter(lambda p: p[0] != p[1]), max_size=4, unique=True))

    def step(b: int, true: set[str]) -> int:
        return table[b][sum(1 << names.index(name) for name in true)]

    accepting = set(draw(st.lists(st.sampled_from(live), max_size=2)))
    return automaton(names, states, step, accepting, sink, sorted(jumps))


@given(automata())
def test_the_table_offers_what_the_automaton_offers(ldba: Ldba) -> None:
    walk = walk_tables(ldba)
    assert walk.options.dtype == np.int64
    for b in ldba.states:
        for letter in range(1 << len(ldba.propositions)):
            row = walk.options[b, letter].tolist()
            offered = ldba.options(b, letter)
            assert tuple(dict.fromkeys(row)) == offered
            assert row[len(offered) :] == [offered[0]] * (walk.width - len(offered))
    assert set(np.flatnonzero(walk.accepting)) == set(ldba.accepting)


def test_nobody_is_offered_to_jump_into_the_sink_or_out_of_it() -> None:
    ldba = stabilization()
    walk = walk_tables(ldba)
    nothing, yellow, blue = ldba.letter([]), ldba.letter(["y"]), ldba.letter(["b"])
    assert walk.options[0, yellow].tolist() == [0, 1]
    assert walk.options[0, nothing].tolist() == [0, 0]  # the jump would be dead: y is not there
    assert walk.options[0, blue].tolist() == [2, 2]
    assert (walk.options[2] == 2).all()


def test_a_jump_that_takes_a_step_begins_where_the_letter_led() -> None:
    ldba = stabilization()
    walk = walk_tables(ldba, "step")
    nothing, yellow, blue = ldba.letter([]), ldba.letter(["y"]), ldba.letter(["b"])
    assert walk.costly
    assert walk.options[0, nothing].tolist() == [0, 1]  # whatever is read, one may jump then
    assert walk.options[0, yellow].tolist() == [0, 1]
    assert walk.options[0, blue].tolist() == [2, 2]  # but not out of the sink
    assert walk.options[1, yellow].tolist() == [1, 1]
    assert (walk.options[2] == 2).all()


def accepts_step_by_step(ldba: Ldba, lasso: Lasso) -> bool:
    """Whether a run with jumps that take a step, none before the first letter, is accepting."""
    walk = walk_tables(ldba, "step")
    graph: nx.DiGraph[tuple[int, int]] = nx.DiGraph()
    letters, back = lasso.letters, len(lasso.stem)
    for i, letter in enumerate(letters):
        after = i + 1 if i + 1 < len(letters) else back
        for b in ldba.states:
            graph.add_edges_from(((i, b), (after, int(c))) for c in walk.options[b, letter])
    reached = graph.subgraph({(0, ldba.initial), *nx.descendants(graph, (0, ldba.initial))})
    rounds = [c for c in nx.strongly_connected_components(reached) if reached.subgraph(c).edges]
    return any(walk.accepting[b] for nodes in rounds for _, b in nodes)


@given(formulas(("a", "b"), 10), lassos(("a", "b")))
def test_whoever_jumps_a_letter_later_is_accepted_all_the_same(
    formula: Formula, lasso: Lasso
) -> None:
    """The first label is read before the first step, so a jump can only come after it."""
    ldba = translate(formula, ("a", "b"))
    assert accepts_step_by_step(ldba, lasso) == accepts(ldba, lasso)


def test_so_it_is_where_jumps_are_needed() -> None:
    for text in ("F G a | F G b", "G F b & F G a", "G (a | X F G b)"):
        parsed = parse(text, ("a", "b"))
        ldba = translate(parsed.formula, ("a", "b"))
        for letters in product(range(4), repeat=4):
            lasso = Lasso(letters[:2], letters[2:])
            assert accepts_step_by_step(ldba, lasso) == accepts(ldba, lasso), (text, lasso)


def test_no_step_is_taken_where_there_are_no_jumps() -> None:
    assert not walk_tables(flatworld_cycle(), "step").costly
    assert not walk_tables(stabilization()).costly


def test_without_jumps_there_is_nothing_to_choose() -> None:
    walk = walk_tables(flatworld_cycle())
    assert not walk.chooses
    assert walk.width == 1
    assert walk_tables(stabilization()).chooses


def test_an_automaton_without_sink_has_sink_minus_one() -> None:
    assert walk_tables(chain(["a"])).sink == -1
    assert walk_tables(stabilization()).sink == 2


def test_too_many_propositions_for_a_table_are_a_finding() -> None:
    names = tuple(f"p{i}" for i in range(MAX_PROPOSITIONS + 1))
    ldba = Ldba(names, ("state 0",), frozenset({0}), None, ())
    with pytest.raises(CompileError, match="JOB606"):
        walk_tables(ldba)
