"""Storm: exact probabilities of LTL in finite Markov chains and decision processes.

Storm (Hensel et al. 2022) translates formulas by a translator that shares no code with this
project's, and computes with fractions. It is the extra `verify`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.ltl import ast, subformulas
from tiloilc.ltl.ast import Formula

if TYPE_CHECKING:
    from stormpy.models import SparseDtmc, SparseMdp, StateLabeling

Int: TypeAlias = NDArray[np.int64]
Distribution: TypeAlias = dict[int, Fraction]
Labels: TypeAlias = dict[str, NDArray[np.bool_]]

EVERYWHERE = "everywhere"
"""A label of all states, for `true`: Storm's LTL stumbles over `!true`."""

SMALLEST = 10**9
"""Denominators up to this are meant: 0.3333333333333333 is a third, as its author wrote it."""


@dataclass(frozen=True, slots=True)
class Process:
    """States with `actions[s]`, what each may lead to; `labels` say which states have them.

    A chain has one action in each state.
    """

    actions: tuple[tuple[Distribution, ...], ...]
    labels: Labels

    @property
    def is_chain(self) -> bool:
        """Whether there is nothing to decide."""
        return all(len(choices) == 1 for choices in self.actions)


class Unanswered(Exception):
    """Storm has no answer: it cannot read what its own translator of formulas has written."""


def fractions(targets: Int, chances: NDArray[np.float64]) -> Distribution:
    """One action's outcomes as fractions that sum to 1: 0 left out, the same targets joined."""
    if len(targets) == 1:
        return {int(targets[0]): Fraction(1)}
    found: Distribution = {}
    for target, chance in zip(targets.tolist(), chances.tolist(), strict=True):
        if chance > 0:
            near = Fraction(chance).limit_denominator(SMALLEST) or Fraction(chance)
            found[target] = found.get(target, Fraction(0)) + near
    total = sum(found.values())
    return {target: found[target] / total for target in sorted(found)}


def has_storm() -> bool:
    """Whether stormpy can be imported."""
    try:
        import stormpy  # noqa: F401
    except ImportError:
        return False
    return True


def require_storm(subject: str) -> None:
    """Raises CompileError RUN713 if stormpy cannot be imported."""
    if not has_storm():
        help = "pip install 'tiloilc[verify]', or bound a run's policies with --method simulate"
        problem = "the package `stormpy` is not installed"
        raise CompileError(Diagnostic.of("RUN713", subject=subject, problem=problem, help=help))


def probabilities(process: Process, property: str, starts: Sequence[int]) -> dict[int, Fraction]:
    """From each of `starts`, the (greatest) probability of a path property in Storm's syntax.

    Raises Unanswered where Storm has no answer.
    """
    import stormpy

    assert starts, "nowhere to begin"
    process = _with_a_last_state(process)
    operator = "P" if process.is_chain else "Pmax"
    (query,) = stormpy.parse_properties(f"{operator}=? [ {property} ]")
    model = _model(process, [*starts, len(process.actions) - 1])
    try:
        result = stormpy.model_checking(model, query, only_initial_states=True)
    except RuntimeError as error:
        if "acc-name headers do not match" not in str(error):
            raise
        raise Unanswered from error
    return {start: Fraction(str(result.get_value(start))) for start in starts}


def _with_a_last_state(process: Process) -> Process:
    """The process and one more state to begin in, where nothing holds and which is never left.

    Storm counts the columns of its product with an automaton by the last state that is entered.
    """
    last = len(process.actions)
    labels = {name: np.append(which, False) for name, which in process.labels.items()}
    return Process((*process.actions, ({last: Fraction(1)},)), labels)


def _model(process: Process, starts: Sequence[int]) -> SparseMdp | SparseDtmc:
    from stormpy import Rational
    from stormpy.datastructures import SparseMatrixBuilder
    from stormpy.models import SparseDtmc, SparseMdp, SparseModelComponents

    chain, states = process.is_chain, len(process.actions)
    rows = [outcome for choices in process.actions for outcome in choices]
    builder = SparseMatrixBuilder[Rational](
        rows=len(rows),
        columns=states,
        entries=sum(map(len, rows)),
        has_custom_row_grouping=not chain,
        row_groups=0 if chain else states,
    )
    row = 0
    known: dict[Fraction, Rational] = {}
    for choices in process.actions:
        if not chain:
            builder.new_row_group(row)
        for outcome in choices:
            for target, chance in outcome.items():
                if chance not in known:
                    known[chance] = Rational(str(chance))
                builder.add_next_value(row, target, known[chance])
            row += 1
    parts = SparseModelComponents[Rational](
        transition_matrix=builder.build(), state_labeling=_labeling(process, starts)
    )
    return SparseDtmc[Rational](parts) if chain else SparseMdp[Rational](parts)


def _labeling(process: Process, starts: Sequence[int]) -> StateLabeling:
    from stormpy.models import StateLabeling

    states = len(process.actions)
    labels = StateLabeling(states)
    first = np.isin(np.arange(states), starts)
    ours = {"init": first, EVERYWHERE: np.ones(states, np.bool_)}
    for name, which in {**ours, **process.labels}.items():
        labels.add_label(name)
        for state in np.flatnonzero(which).tolist():
            labels.add_label_to_state(name, state)
    return labels


def letter_labels(letters: Int, propositions: int) -> Labels:
    """A label for each proposition, by its number: names can be anything."""
    return {f"p{i}": (letters >> i & 1).astype(np.bool_) for i in range(propositions)}


def storm_text(formula: Formula, names: tuple[str, ...]) -> str:
    """`formula` for Storm, which has ! & | X F G U only: by definition, not by our rewriting.

    Propositions are labels as `letter_labels` has them, in the order of `names`.
    """
    texts: dict[Formula, str] = {}
    for part in subformulas(formula):
        texts[part] = f"({_part(part, [texts[child] for child in part.children], names)})"
    return texts[formula]


def _part(part: Formula, operands: list[str], names: tuple[str, ...]) -> str:
    match part:
        case ast.Constant(value):
            return f'"{EVERYWHERE}"' if value else f'!"{EVERYWHERE}"'
        case ast.Proposition(name):
            return f'"p{names.index(name)}"'
        case ast.And():
            return " & ".join(operands)
        case ast.Or():
            return " | ".join(operands)
        case ast.Not():
            return f"!{operands[0]}"
        case ast.Next():
            return f"X {operands[0]}"
        case ast.Eventually():
            return f"F {operands[0]}"
        case ast.Always():
            return f"G {operands[0]}"
    left, right = operands
    match part:
        case ast.Until():
            return f"{left} U {right}"
        case ast.WeakUntil():
            return f"({left} U {right}) | (G {left})"
        case ast.Release():
            return f"!((!{left}) U (!{right}))"
        case ast.StrongRelease():
            return f"{right} U ({left} & {right})"
        case ast.Implies():
            return f"(!{left}) | {right}"
        case ast.Iff():
            return f"({left} & {right}) | ((!{left}) & (!{right}))"
        case ast.Xor():
            return f"({left} & (!{right})) | ((!{left}) & {right})"
    raise AssertionError(f"not an operator: {part!r}")
