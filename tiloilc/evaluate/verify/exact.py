"""Exact probabilities on finite tasks: of a run's policies, and the most that any could reach."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tiloilc.evaluate.verify.chain import ACCEPTING, Chain
from tiloilc.evaluate.verify.storm import (
    Ask,
    Process,
    Unanswered,
    fractions,
    letter_labels,
    probabilities,
    storm_text,
)
from tiloilc.ltl import parse
from tiloilc.ltl.ast import Formula
from tiloilc.plan import Plan
from tiloilc.product import Int, walk_tables

if TYPE_CHECKING:
    from tiloilc.tasks import MarkovModel

ACCEPTS = f'G F "{ACCEPTING}"'


@dataclass(frozen=True, slots=True)
class Exact:
    """What is known of one agent: the probability that its behaviour satisfies the formula.

    `accepted` is that of its own run of the automaton, which is less if it takes ε-jumps that it
    should not, or none; `at_least` says that for that reason the probability may be greater.
    `nodes` is the size of the chain.
    """

    probability: Fraction
    accepted: Fraction
    at_least: bool
    nodes: int


@dataclass(frozen=True, slots=True)
class Maximum:
    """The greatest probability that any policy could reach, without a time limit.

    `exact`: none reaches more; otherwise one reaches at least that. `how` says how it is known.
    """

    probability: Fraction
    exact: bool
    how: str


def formula_of(plan: Plan) -> Formula | None:
    """The formula; None where the task file names an automaton instead."""
    return parse(plan.formula, plan.ldba.propositions).formula if plan.formula else None


def exactly(chain: Chain, plan: Plan, ask: Ask = probabilities) -> Exact:
    """The probability of one agent, by Storm.

    A run is accepted if it ends in a bottom component with an accepting node. The automaton is
    deterministic but for jumps, so without any this says it all; with jumps Storm is asked about
    the formula itself, of the labels alone. Raises Unanswered without a probability of acceptance.
    """
    process = chain.process(len(plan.ldba.propositions))
    accepted = _expected(ask, process, ACCEPTS, chain.initial)
    formula = formula_of(plan)
    if not plan.ldba.jumps or accepted == 1:
        return Exact(accepted, accepted, False, len(chain.states))
    if formula is None:
        return Exact(accepted, accepted, True, len(chain.states))
    try:
        satisfied = formula_probability(chain, formula, plan.ldba.propositions, ask)
    except Unanswered:
        return Exact(accepted, accepted, True, len(chain.states))
    return Exact(satisfied, accepted, False, len(chain.states))


def formula_probability(
    chain: Chain, formula: Formula, names: tuple[str, ...], ask: Ask = probabilities
) -> Fraction:
    """The probability of `formula` by labels alone, without our automaton.

    Raises Unanswered where Storm has no answer.
    """
    process = chain.process(len(names))
    return _expected(ask, process, storm_text(formula, names), chain.initial)


def maximum(model: MarkovModel, letters: Int, plan: Plan, ask: Ask = probabilities) -> Maximum:
    """The most that any policy reaches in `model`, whose state s is labelled `letters[s]`.

    Of a formula by Storm alone; where the task names an automaton, or Storm has no answer, in the
    product with it, jumps being choices. Raises Unanswered if it has none there either.
    """
    names, formula = plan.ldba.propositions, formula_of(plan)
    size = f"Storm on {len(letters):,} states and {model.successor.shape[1]} actions"
    lattice = model.how.removeprefix("dynamic programming on ")  # that is how the optimum is found
    how = size if model.exact else f"{size}; {lattice}"
    if formula is not None:
        process = Process(_actions(model), letter_labels(letters, len(names)))
        try:
            best = _expected(ask, process, storm_text(formula, names), model.initial)
        except Unanswered:
            pass
        else:
            return Maximum(best, model.exact, how)
    best = _expected(ask, _product(model, letters, plan), ACCEPTS, model.initial)
    return Maximum(best, model.exact, how)


def _expected(ask: Ask, process: Process, property: str, initial: NDArray[np.float64]) -> Fraction:
    """The probability of a property, the first state being one of the first ones of `process`."""
    starts = np.flatnonzero(initial > 0)
    weights = fractions(starts, initial[starts])
    found = ask(process, property, starts.tolist())
    return sum((weight * found[s] for s, weight in weights.items()), Fraction(0))


def _actions(model: MarkovModel) -> tuple[tuple[dict[int, Fraction], ...], ...]:
    """What each action may lead to, in each state; actions that do the same are one."""
    found = []
    for after, chance in zip(model.successor, model.probability, strict=True):
        outcomes = [fractions(t, p) for t, p in zip(after, chance, strict=True)]
        different = {tuple(outcome.items()): outcome for outcome in outcomes}
        found.append(tuple(different[key] for key in sorted(different)))
    return tuple(found)


def _product(model: MarkovModel, letters: Int, plan: Plan) -> Process:
    """Nodes (s, b), the label of s not read yet: an agent chooses the option, then the action.

    The first n nodes are those of the automaton's start. A node accepts if b does.
    """
    walk, n = walk_tables(plan.ldba), len(letters)
    moves = _actions(model)
    order = [walk.initial, *(b for b in range(walk.states) if b != walk.initial)]
    place = {b: i * n for i, b in enumerate(order)}
    actions = []
    for b in order:
        for s in range(n):
            options = dict.fromkeys(walk.options[b, letters[s]].tolist())
            choices = [
                {place[c] + t: p for t, p in outcome.items()}
                for c in options
                for outcome in moves[s]
            ]
            actions.append(tuple(choices))
    accepting = np.repeat(walk.accepting[order], n)
    return Process(tuple(actions), {ACCEPTING: accepting})
