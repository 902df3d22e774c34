"""Small labelled Markov decision processes, and the best that an automaton can do in one.

Nothing here is shared with what the package does with automata: maximal end components come from
scipy, probabilities from policy iteration with numpy's linear solver.
"""

from __future__ import annotations

import random
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from tiloilc.automaton.ldba import Ldba

Distribution = dict[int, Fraction]

IMPROVES = 1e-12
"""A policy changes its mind for more than the rounding of a solved system of equations."""


@dataclass(frozen=True, slots=True)
class Mdp:
    """`labels[s]` is the letter of state s, `actions[s]` what may happen there; it starts in 0."""

    labels: tuple[int, ...]
    actions: tuple[tuple[Distribution, ...], ...]


def random_mdp(generator: random.Random, propositions: int) -> Mdp:
    """Of 4 to 8 states with 1 to 3 actions each, half of which lead to one state for sure.

    In most there is no way back, or seldom one: then chance decides between several ends.
    """
    count = generator.randint(4, 8)
    back = generator.choice((0.0, 0.1, 0.3, 1.0))
    actions = []
    for state in range(count):
        number = generator.choice((1, 1, 2, 2, 3))
        lowest = [0 if generator.random() < back else state for _ in range(number)]
        actions.append(tuple(_distribution(generator, range(low, count)) for low in lowest))
    labels = tuple(generator.randrange(1 << propositions) for _ in range(count))
    return Mdp(labels, tuple(actions))


def _distribution(generator: random.Random, states: range) -> Distribution:
    branches = min(generator.choice((1, 1, 1, 2, 2, 3)), len(states))
    targets = sorted(generator.sample(states, branches))
    weights = [generator.randint(1, 5) for _ in targets]
    return {t: Fraction(w, sum(weights)) for t, w in zip(targets, weights, strict=True)}


@dataclass(frozen=True, slots=True)
class Choice:
    """Something an agent may do in a node of a product: whether it is marked, and what comes."""

    marked: bool
    outcome: dict[int, float]


def best_probability(mdp: Mdp, ldba: Ldba) -> float:
    """The greatest probability of accepting runs, jumps being choices of the agent.

    In a node (s, b) the agent has arrived in s, knows it, and reads its label in b next.
    """
    return buchi_probability(_product(mdp, ldba))


def _product(mdp: Mdp, ldba: Ldba) -> list[list[Choice]]:
    """The choices of each node that can be reached; node 0 is the start."""
    index = {(0, ldba.initial): 0}
    order = [(0, ldba.initial)]
    nodes = []
    for s, b in order:
        choices = []
        for target, marked in _arrivals(ldba, b, mdp.labels[s]):
            for distribution in mdp.actions[s]:
                outcome = {}
                for following, probability in distribution.items():
                    node = following, target
                    if node not in index:
                        index[node] = len(order)
                        order.append(node)
                    outcome[index[node]] = float(probability)
                choices.append(Choice(marked, outcome))
        nodes.append(choices)
    return nodes


def _arrivals(ldba: Ldba, state: int, letter: int) -> Iterator[tuple[int, bool]]:
    """Where the agent may go on `letter`, and whether that accepts; nothing where all is lost.

    With accepting states it is `Ldba.options` that says where, as in training.
    """
    if not ldba.accepting_edges:
        for target in ldba.options(state, letter):
            if target != ldba.sink:
                yield target, target in ldba.accepting
        return
    for source in (state, *(t for s, t in ldba.jumps if s == state)):
        for number, edge in enumerate(ldba.edges):
            reads = edge.source == source and any(letter in cube for cube in edge.guard)
            if reads and edge.target != ldba.sink:
                yield edge.target, number in ldba.accepting_edges


def buchi_probability(nodes: Sequence[Sequence[Choice]]) -> float:
    """The greatest probability, from node 0, of taking marked choices again and again.

    In an end component an agent can do everything for ever: those with a marked choice are won.
    Seen as one node each, the others leave or lose, so that every policy ends somewhere.
    """
    component, inner = end_components(nodes)
    won = {
        component[n]
        for n, choices in enumerate(nodes)
        for c, choice in enumerate(choices)
        if choice.marked and (n, c) in inner
    }
    leaving: dict[int, list[dict[int, float]]] = {number: [] for number in component}
    for n, choices in enumerate(nodes):
        for c, choice in enumerate(choices):
            if (n, c) not in inner and component[n] not in won:
                outcome: dict[int, float] = {}
                for target, probability in choice.outcome.items():
                    goal = component[target]
                    outcome[goal] = outcome.get(goal, 0.0) + probability
                leaving[component[n]].append(outcome)
    return _reaching(leaving, won)[component[0]]


def end_components(
    nodes: Sequence[Sequence[Choice]],
) -> tuple[list[int], set[tuple[int, int]]]:
    """The maximal end component of each node (a number of its own if none), and their choices.

    Baier and Katoen, Principles of Model Checking, algorithm 47: choices that may leave a strongly
    connected component go, until none does.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    inner = {(n, c) for n, choices in enumerate(nodes) for c in range(len(choices))}
    while True:
        pairs = sorted({(n, t) for n, c in inner for t in nodes[n][c].outcome})
        rows, columns = [n for n, _ in pairs], [t for _, t in pairs]
        shape = (len(nodes), len(nodes))
        graph = csr_array((np.ones(len(pairs)), (rows, columns)), shape=shape)
        component = connected_components(graph, directed=True, connection="strong")[1].tolist()
        kept = {
            (n, c)
            for n, c in inner
            if all(component[t] == component[n] for t in nodes[n][c].outcome)
        }
        if kept == inner:
            return component, inner
        inner = kept


def _reaching(leaving: dict[int, list[dict[int, float]]], goals: set[int]) -> dict[int, float]:
    """The greatest probability of reaching `goals` from each node, by policy iteration (Howard).

    Needs that no node can be stayed in for ever with a choice; one without choices has lost.
    """
    order: dict[Hashable, int] = {node: i for i, node in enumerate(sorted(leaving))}
    policy = {node: 0 for node, choices in leaving.items() if choices}
    while True:
        system = np.eye(len(order))
        known = np.array([float(node in goals) for node in sorted(leaving)])
        for node, choice in policy.items():
            for target, probability in leaving[node][choice].items():
                system[order[node], order[target]] -= probability
        solved: NDArray[np.float64] = np.linalg.solve(system, known)
        value = {node: float(solved[order[node]]) for node in leaving}
        better = {}
        for node, choice in policy.items():
            worth = [sum(p * value[t] for t, p in o.items()) for o in leaving[node]]
            best = max(range(len(worth)), key=worth.__getitem__)
            if worth[best] > worth[choice] + IMPROVES:
                better[node] = best
        if not better:
            return value
        policy |= better
