"""The stages of small automata against their definition (Eq. 6 and 8), path by path."""

from collections.abc import Iterator
from itertools import product

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.plan.automata import automaton
from tiloilc.automaton.ldba import Ldba
from tiloilc.plan.stages import ambiguous_stages, stage_plan

Path = tuple[int, ...]


@st.composite
def automata(draw: st.DrawFn) -> Ldba:
    """Up to six live states, of which one or two accept, with and without a sink and jumps."""
    live = draw(st.integers(2, 6))
    sink = live if draw(st.booleans()) else None
    n = live + (sink is not None)
    targets = draw(st.lists(st.integers(0, n - 1), min_size=2 * live, max_size=2 * live))
    accepting = draw(st.sets(st.integers(0, live - 1), min_size=1, max_size=2))
    pairs = [(b, c) for b, c in product(range(live), repeat=2) if b != c]
    jumps = sorted(draw(st.sets(st.sampled_from(pairs), max_size=3)))
    ldba = automaton(["a"], n, lambda b, true: targets[2 * b + len(true)], accepting, sink, jumps)
    assume(distance(ldba, ldba.initial) >= 0)
    return ldba


def successors(ldba: Ldba, b: int) -> set[int]:
    """The live states that some letter leads to, by a jump or without."""
    return {c for letter in (0, 1) for c in ldba.options(b, letter)} - {ldba.sink}


def paths(ldba: Ldba, path: Path) -> Iterator[Path]:
    """The acyclic paths that go on from `path`, it included, and stop at the first acceptance."""
    yield path
    if path[-1] not in ldba.accepting:
        for c in successors(ldba, path[-1]) - set(path):
            yield from paths(ldba, (*path, c))


def distance(ldba: Ldba, b: int) -> int:
    ways = [path for path in paths(ldba, (b,)) if path[-1] in ldba.accepting]
    return min((len(path) - 1 for path in ways), default=-1)


def orders(ldba: Ldba, starts: set[int], gone: int) -> dict[int, tuple[int, int]]:
    """SIDX and N of what can be met from `starts`, where `gone` edges count already."""
    met = [path for b in starts for path in paths(ldba, (b,))]
    order = {}
    for b in {path[-1] for path in met}:
        index = max(gone + len(path) - 1 for path in met if path[-1] == b)
        full = [len(p) for p in met if p[-1] in ldba.accepting and b in p]
        direct = index + max(distance(ldba, b), 0)
        order[b] = (index, max(1, direct, *(gone + edges - 1 for edges in full)))
    return order


@settings(max_examples=300, deadline=None)
@given(automata())
def test_index_and_length_are_those_of_the_longest_paths_that_segments_take(ldba: Ldba) -> None:
    after = {c for b in ldba.accepting for c in successors(ldba, b)}
    expected = dict.fromkeys(ldba.states, (0, 0)) | orders(ldba, after, 1)
    if ldba.initial in ldba.accepting:
        expected |= orders(ldba, successors(ldba, ldba.initial), 1)
        expected[ldba.initial] = (0, expected[ldba.initial][1])
    else:
        expected |= orders(ldba, {ldba.initial}, 0)
    stages = stage_plan(ldba)
    assert stages.index == tuple(expected[b][0] for b in ldba.states)
    assert stages.length == tuple(max(1, expected[b][1], distance(ldba, b)) for b in ldba.states)


@settings(max_examples=300, deadline=None)
@given(automata())
def test_buffers_and_ambiguities_are_those_of_the_ways_between_states(ldba: Ldba) -> None:
    far = [distance(ldba, b) for b in ldba.states]
    ways = [{path[-1] for path in paths(ldba, (b,))} - {b} for b in ldba.states]
    stages = stage_plan(ldba)
    assert stages.distance == tuple(far)
    for b in ldba.states:
        positive = {c for c in ways[b] if far[c] >= 0 and (far[c] < far[b] or b not in ways[c])}
        negative = {b, *(c for c in ldba.states if b in ways[c])} - positive
        compared = (sorted(positive), sorted(negative | {stages.sink_buffer}))
        found = (list(stages.positive[b]), list(stages.negative[b]))
        assert found == (compared if far[b] > 0 else ([], []))
    tied = {
        b
        for b, c in product(ldba.states, repeat=2)
        if b != c and far[b] == far[c] > 0 and (c in ways[b] or b in ways[c])
    }
    groups = ambiguous_stages(ldba, stages)
    assert groups == tuple(
        tuple(sorted(b for b in tied if far[b] == d)) for d in sorted({far[b] for b in tied})
    )
