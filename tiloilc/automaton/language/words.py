"""Questions about the language of an automaton: membership, emptiness, example words.

Jumps are taken as the agent takes them: at every letter one may read it in a jump's target instead.
Words are found letter set by letter set; a letter set is written as its least letter.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import TypeVar

from tiloilc.automaton.draft import components
from tiloilc.automaton.ldba import Cube, Edge, Ldba, StateId
from tiloilc.ltl import Lasso

T = TypeVar("T", bound=Hashable)

Moves = Callable[[T], Iterator[tuple[T, bool, int]]]
"""The moves of a graph: target, whether the move accepts, the letter read."""


def accepts(ldba: Ldba, lasso: Lasso) -> bool:
    """Whether some run of `ldba` on `lasso` accepts."""
    letters, back = lasso.letters, len(lasso.stem)

    def moves(place: tuple[StateId, int]) -> Iterator[tuple[tuple[StateId, int], bool, int]]:
        state, position = place
        letter = letters[position]
        following = position + 1 if position + 1 < len(letters) else back
        for edge, mark in edges_with_jumps(ldba, state):
            if any(letter in cube for cube in edge.guard):
                yield (edge.target, following), mark, letter

    return accepting_lasso((ldba.initial, 0), moves) is not None


def is_empty(ldba: Ldba) -> bool:
    """Whether `ldba` accepts no word at all."""
    return accepted_word(ldba) is None


def accepted_word(ldba: Ldba) -> Lasso | None:
    """A short word that `ldba` accepts; None if there is none."""

    def moves(state: StateId) -> Iterator[tuple[StateId, bool, int]]:
        for edge, mark in edges_with_jumps(ldba, state):
            yield edge.target, mark, least_letter(edge.guard)

    return accepting_lasso(ldba.initial, moves)


def edges_with_jumps(ldba: Ldba, state: StateId) -> Iterator[tuple[Edge, bool]]:
    """The live edges that may be read in `state`, by its jumps too, and whether they accept."""
    sources = (state, *ldba.jump_targets[state])
    for source in sources:
        for index in ldba.outgoing_indices[source]:
            if ldba.edges[index].target != ldba.sink:
                yield ldba.edges[index], ldba.is_marked(index)


def least_letter(guard: Sequence[Cube]) -> int:
    """The letter of a letter set with the least number: few propositions, early ones first."""
    return min((cube.value for cube in guard), key=lambda value: (value.bit_count(), value))


def accepting_lasso(start: T, moves: Moves[T]) -> Lasso | None:
    """A word along a path from `start` and round an accepting cycle; None if there is none.

    The path is a shortest one to the cycle, and the cycle a shortest one through its edge.
    """
    order, graph = _explore(start, moves)
    component = components([[t for t, _, _ in edges] for edges in graph])
    distance, path = _shortest(graph, 0, lambda node: True)
    best: tuple[int, tuple[int, ...], tuple[int, ...]] | None = None
    for node in sorted(range(len(order)), key=lambda n: distance[n]):
        if best is not None and distance[node] + 1 > best[0]:
            break
        for target, mark, letter in graph[node]:
            if not mark or component[node] != component[target]:
                continue
            here = component[node]
            inside = [n for n, c in enumerate(component) if c == here]
            steps, back = _shortest(graph, target, set(inside).__contains__)
            total = distance[node] + 1 + steps[node]
            if best is None or total < best[0]:
                best = total, _letters(path, node), (letter, *_letters(back, node))
    return None if best is None else shortened(best[1], best[2])


def shortened(stem: tuple[int, ...], loop: tuple[int, ...]) -> Lasso:
    """The word `stem` · `loop`^ω written as short as it can be."""
    while stem and stem[-1] == loop[-1]:
        stem, loop = stem[:-1], (loop[-1], *loop[:-1])
    for length in range(1, len(loop) + 1):
        if loop == loop[:length] * (len(loop) // length):
            return Lasso(stem, loop[:length])
    raise AssertionError("a loop is one round of itself")


Path = dict[int, tuple[int, int] | None]
"""The way back to a start: of each node the node before and the letter between."""


def _explore(start: T, moves: Moves[T]) -> tuple[list[T], list[list[tuple[int, bool, int]]]]:
    index = {start: 0}
    order = [start]
    graph = []
    for node in order:
        edges = []
        for target, mark, letter in moves(node):
            if target not in index:
                index[target] = len(order)
                order.append(target)
            edges.append((index[target], mark, letter))
        graph.append(edges)
    return order, graph


def _shortest(
    graph: list[list[tuple[int, bool, int]]], start: int, inside: Callable[[int], bool]
) -> tuple[dict[int, int], Path]:
    distance = {start: 0}
    path: Path = {start: None}
    queue = deque([start])
    while queue:
        node = queue.popleft()
        for target, _, letter in graph[node]:
            if target not in distance and inside(target):
                distance[target] = distance[node] + 1
                path[target] = (node, letter)
                queue.append(target)
    return distance, path


def _letters(path: Path, node: int) -> tuple[int, ...]:
    letters = []
    step = path[node]
    while step is not None:
        node, letter = step
        letters.append(letter)
        step = path[node]
    return tuple(reversed(letters))
