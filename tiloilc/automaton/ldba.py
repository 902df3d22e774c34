"""Limit-deterministic Büchi automata over sets of letters (paper, definitions 2.1 and 2.2)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

Letter = int
"""A letter of 2^AP as bits: bit i is proposition i of the automaton's `propositions`."""

StateId = int


@dataclass(frozen=True, slots=True, order=True)
class Cube:
    """A conjunction of literals: the letters x with `x & mask == value`."""

    mask: int
    value: int

    def __contains__(self, letter: Letter) -> bool:
        return letter & self.mask == self.value


@dataclass(frozen=True, slots=True, order=True)
class Edge:
    """An edge on every letter of a union of cubes, sorted."""

    source: StateId
    target: StateId
    guard: tuple[Cube, ...]


@dataclass(frozen=True)
class Ldba:
    """A complete automaton with state-based Büchi acceptance and explicit ε-jumps.

    Apart from jumps it is deterministic: the guards of a state's edges partition the letters.
    `sink` is the one state from which no accepting cycle can be reached (it loops on every letter),
    None if there is none. `jumps` are pairs (from, to): while reading a letter in `from` the agent
    may take the edge of `to` instead. States are numbered from 0 in breadth-first order, letters
    in the order of `propositions`, those of a HOA file in the file's order; the initial state is 0,
    the sink the last one. `names[b]` says what is left to do in b, or what a file calls it. With
    edge-based acceptance `accepting` is empty and `accepting_edges` are places in `edges`.
    """

    propositions: tuple[str, ...]
    names: tuple[str, ...]
    accepting: frozenset[StateId]
    sink: StateId | None
    edges: tuple[Edge, ...]
    jumps: tuple[tuple[StateId, StateId], ...] = ()
    accepting_edges: frozenset[int] = frozenset()

    initial: StateId = 0

    @property
    def states(self) -> range:
        """All states."""
        return range(len(self.names))

    @cached_property
    def outgoing(self) -> tuple[tuple[Edge, ...], ...]:
        """The edges of each state, in the order of `edges`."""
        return tuple(tuple(e for e in self.edges if e.source == b) for b in self.states)

    @cached_property
    def outgoing_indices(self) -> tuple[tuple[int, ...], ...]:
        """The places in `edges` of the edges of each state."""
        places: list[list[int]] = [[] for _ in self.states]
        for index, edge in enumerate(self.edges):
            places[edge.source].append(index)
        return tuple(tuple(row) for row in places)

    @cached_property
    def jump_targets(self) -> tuple[tuple[StateId, ...], ...]:
        """Where one may jump from each state, in ascending order."""
        return tuple(tuple(t for s, t in self.jumps if s == b) for b in self.states)

    def is_marked(self, index: int) -> bool:
        """Whether the edge `edges[index]` accepts: is marked, or enters an accepting state."""
        return index in self.accepting_edges or self.edges[index].target in self.accepting

    def letter(self, true: Iterable[str]) -> Letter:
        """The letter in which just the named propositions hold."""
        return sum(1 << self.propositions.index(name) for name in set(true))

    def successor(self, state: StateId, letter: Letter) -> StateId:
        """δ(state, letter), without jumps."""
        for edge in self.outgoing[state]:
            if any(letter in cube for cube in edge.guard):
                return edge.target
        raise AssertionError(f"state {state} has no edge for letter {letter}: not complete")

    def options(self, state: StateId, letter: Letter) -> tuple[StateId, ...]:
        """Where the agent may go on `letter`: δ(state, ·) first, then by each jump; live ones only.

        If all are dead, the sink is the one option (algorithms: free ε-jumps).
        """
        reached = [self.successor(b, letter) for b in (state, *self.jump_targets[state])]
        live = tuple(dict.fromkeys(b for b in reached if b != self.sink))
        return live or (reached[0],)

    def run(self, letters: Sequence[Letter], state: StateId | None = None) -> list[StateId]:
        """The states after each letter, without jumps, from `state` (the initial one if None)."""
        current = self.initial if state is None else state
        visited = []
        for letter in letters:
            current = self.successor(current, letter)
            visited.append(current)
        return visited
