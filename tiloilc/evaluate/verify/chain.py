"""The Markov chain that a policy makes of a finite task: what is left when it decides everything.

A node is a pair (s, b): the model is in s, whose label has been read, and the automaton is in b.
There is no time limit: the horizon of a task is one of training. b_0 = δ(b_init, L(s_0)), as in the
product that is trained in, and ε-jumps are the policy's own. Where jumps take a step, the node is
the one after the jump: nothing is read meanwhile.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from tiloilc.evaluate.verify.storm import Process, fractions, letter_labels
from tiloilc.learn import Policy
from tiloilc.product import Int, Walk

if TYPE_CHECKING:
    from tiloilc.tasks import MarkovModel

ACCEPTING = "accepting"
"""The label of nodes whose automaton state accepts."""

MAX_PAIRS = 1_000_000
"""Pairs (s, b) beyond which a task is not enumerated; those of the paper have a few thousand."""

AT_ONCE = 20_000
"""Pairs that a policy is asked about in one call."""


@dataclass(frozen=True, slots=True, eq=False)
class Decisions:
    """What a run's policies decide, one after another along the first axis.

    columns  int64 [seed, n, B]  the action taken in (s, b), as a column of the model
    arrivals  int64 [seed, n, B]  the automaton state after arriving in s while in b
    """

    columns: Int
    arrivals: Int


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """The nodes that can be reached; `edges` [n, n] are the probabilities of steps.

    `states` are the model's, `automaton` the automaton's, `letters` the labels of the model's
    states, `initial` how likely each node is the first; all [n].
    """

    states: Int
    automaton: Int
    letters: Int
    initial: NDArray[np.float64]
    accepting: NDArray[np.bool_]
    edges: csr_array

    def process(self, propositions: int) -> Process:
        """The chain for Storm: a label for each proposition, and ACCEPTING."""
        first, targets, chances = self.edges.indptr, self.edges.indices, self.edges.data
        actions = tuple(
            (fractions(targets[i:j].astype(np.int64), chances[i:j]),)
            for i, j in zip(first[:-1].tolist(), first[1:].tolist(), strict=True)
        )
        labels = letter_labels(self.letters, propositions) | {ACCEPTING: self.accepting}
        return Process(actions, labels)

    def ends(self) -> tuple[Int, NDArray[np.bool_]]:
        """The strongly connected component of each node [n], and which components [m] are bottom.

        A run of the chain comes to a bottom component with probability 1, and then to each of
        its nodes again and again.
        """
        count, component = connected_components(self.edges, directed=True, connection="strong")
        bottom = np.ones(count, np.bool_)
        edges = self.edges.tocoo()
        leaving = component[edges.row] != component[edges.col]
        bottom[component[edges.row[leaving]]] = False
        return component.astype(np.int64), bottom


def decisions(
    policy: Policy, model: MarkovModel, letters: Int, walk: Walk, seeds: int
) -> Decisions:
    """Ask the greedy policies of `seeds` agents about each pair of states."""
    n, states = len(letters), walk.states
    order = np.argsort(model.actions)
    known = np.asarray(model.actions)[order]
    observations = model.seen
    columns = np.zeros((seeds, n * states), np.int64)
    arrivals = np.zeros((seeds, n * states), np.int64)
    for start in range(0, n * states, AT_ONCE):
        pairs = np.arange(start, min(start + AT_ONCE, n * states))
        s, b = pairs // states, pairs % states
        seen = np.broadcast_to(observations[s], (seeds, len(pairs), observations.shape[1])).copy()
        here = np.broadcast_to(b, (seeds, len(pairs))).copy()
        actions = policy.act(seen, here, True)
        columns[:, pairs] = order[np.searchsorted(known, actions)]
        options = np.broadcast_to(
            walk.options[b, letters[s]], (seeds, len(pairs), walk.width)
        ).copy()
        chosen = policy.choose(seen, options, True) if walk.chooses else options[..., 0]
        arrivals[:, pairs] = chosen
    shape = (seeds, n, states)
    return Decisions(columns.reshape(shape), arrivals.reshape(shape))


def induced_chain(
    model: MarkovModel, letters: Int, walk: Walk, columns: Int, arrivals: Int
) -> Chain:
    """The chain of one agent, whose decisions are [n, B]."""
    n, states = len(letters), walk.states
    s, b = np.divmod(np.arange(n * states), states)
    after = model.successor[s, columns.reshape(-1)]
    chance = model.probability[s, columns.reshape(-1)]
    target = after * states + arrivals[after, b[:, None]]
    source = np.repeat(np.arange(n * states), after.shape[1])
    likely = chance.reshape(-1) > 0
    entries = (chance.reshape(-1)[likely], (source[likely], target.reshape(-1)[likely]))
    every = csr_array(entries, shape=(n * states, n * states))
    every.sum_duplicates()
    first = np.arange(n) * states + arrivals[:, walk.initial]
    begins = np.flatnonzero(model.initial > 0)
    reached = np.zeros(n * states, np.bool_)
    for node in first[begins].tolist():
        if not reached[node]:
            found = breadth_first_order(every, node, return_predecessors=False)
            reached[found] = True
    nodes = np.flatnonzero(reached)
    initial = np.zeros(n * states)
    np.add.at(initial, first, model.initial)
    return Chain(
        s[nodes],
        b[nodes],
        letters[s[nodes]],
        initial[nodes],
        walk.accepting[b[nodes]],
        csr_array(every[nodes][:, nodes]),
    )
