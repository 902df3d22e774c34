"""Storm: exact probabilities of LTL in finite Markov chains and decision processes.

Storm (Hensel et al. 2022) translates formulas by a translator that shares no code with this
project's, and computes with fractions. It is the extra `verify`.
"""

from __future__ import annotations

import json
import select
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate.verify import answer as answering
from tiloilc.evaluate.verify.answer import Question, answer
from tiloilc.ltl import ast, subformulas
from tiloilc.ltl.ast import Formula

Int: TypeAlias = NDArray[np.int64]
Distribution: TypeAlias = dict[int, Fraction]
Labels: TypeAlias = dict[str, NDArray[np.bool_]]
Answers: TypeAlias = dict[int, Fraction]

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


Ask: TypeAlias = Callable[[Process, str, Sequence[int]], Answers]
"""What is asked about a process: `probabilities`, here or in a program of its own."""


class Unanswered(Exception):
    """Storm has no answer, and why."""


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


def probabilities(process: Process, property: str, starts: Sequence[int]) -> Answers:
    """From each of `starts`, the (greatest) probability of a path property in Storm's syntax.

    Raises Unanswered where Storm has no answer. It cannot be interrupted: see `Storm`.
    """
    return _answers(starts, answer(_question(process, property, starts)))


class Storm:
    """Storm in a program of its own, which is ended when an answer takes more than `limit` s.

    A context: the program goes with it, also when what it asked for is interrupted.
    """

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.program: subprocess.Popen[str] | None = None

    def __enter__(self) -> Storm:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def probabilities(self, process: Process, property: str, starts: Sequence[int]) -> Answers:
        """As the function of this name; Unanswered also after the limit, or without memory."""
        if self.program is None:
            command = [sys.executable, "-P", answering.__file__]
            pipe = subprocess.PIPE
            self.program = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
        assert self.program.stdin is not None
        assert self.program.stdout is not None
        text = json.dumps(_question(process, property, starts))
        line = ""
        try:
            self.program.stdin.write(text + "\n")
            self.program.stdin.flush()
            if not select.select([self.program.stdout], [], [], self.limit)[0]:
                self._end()
                raise Unanswered(f"Storm takes longer than {self.limit:g} s")
            line = self.program.stdout.readline()
        except BrokenPipeError:
            pass
        if not line:
            status = self.program.wait()
            self._end()
            raise Unanswered(f"Storm ended without an answer (status {status})")
        return _answers(starts, json.loads(line))

    def _end(self) -> None:
        if self.program is not None:
            self.program.kill()
            self.program.communicate()
            self.program = None


def _question(process: Process, property: str, starts: Sequence[int]) -> Question:
    """The question, of the process and one more state to begin in, which is never left.

    Storm counts the columns of its product with an automaton by the last state that is entered.
    """
    assert starts, "nowhere to begin"
    last = len(process.actions)
    named = {name: np.flatnonzero(which).tolist() for name, which in process.labels.items()}
    texts: dict[Fraction, str] = {}
    actions = [
        [
            [(target, texts.setdefault(chance, str(chance))) for target, chance in outcome.items()]
            for outcome in choices
        ]
        for choices in (*process.actions, ({last: Fraction(1)},))
    ]
    return {
        "actions": actions,
        "labels": {"init": [*starts, last], EVERYWHERE: list(range(last + 1)), **named},
        "choice": not process.is_chain,
        "property": property,
        "starts": list(starts),
    }


def _answers(starts: Sequence[int], found: list[str] | None) -> Answers:
    if found is None:
        raise Unanswered("Storm cannot read what its own translator of formulas has written")
    return dict(zip(starts, map(Fraction, found), strict=True))


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
