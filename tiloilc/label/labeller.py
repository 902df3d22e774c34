"""All propositions of a task as one function: observations to letters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic, SourceText, counted
from tiloilc.label.check import Checker
from tiloilc.label.functions import Array
from tiloilc.label.python import python_predicate
from tiloilc.label.syntax import parse

NO_PYTHON: Mapping[str, SourceText | str] = {}

Test = Callable[[Array], Array]
"""Observations [..., d] to truth values that broadcast to [...]."""


BITS = np.int64(1) << np.arange(63, dtype=np.int64)
"""What each proposition is worth in a letter."""


@dataclass(frozen=True, slots=True)
class Labeller:
    """Computes letters; proposition i of `propositions` is bit i.

    A pure function of the observations, which are computed with in float64. NaN makes every
    comparison false except `!=`, and lies in no box or ball; division by zero gives ±inf or NaN,
    without a warning.
    """

    propositions: tuple[str, ...]
    tests: tuple[Test, ...]

    def truth(self, observations: NDArray[np.generic]) -> NDArray[np.bool_]:
        """Truth values [..., propositions] of observations [..., d].

        Raises CompileError SPEC117 if a Python predicate fails.
        """
        batch = observations.shape[:-1]
        values = np.empty((*batch, len(self.tests)), dtype=np.bool_)
        numbers = np.asarray(observations, dtype=np.float64)
        with np.errstate(all="ignore"):
            for bit, test in enumerate(self.tests):
                values[..., bit] = test(numbers)
        return values

    def __call__(self, observations: NDArray[np.generic]) -> NDArray[np.int64]:
        """Letters [...] of observations [..., d]."""
        letters: NDArray[np.int64] = self.truth(observations) @ BITS[: len(self.tests)]
        return letters


def compile_predicates(
    predicates: Mapping[str, SourceText | str],
    fields: Mapping[str, tuple[int, int]],
    python: Mapping[str, SourceText | str] = NO_PYTHON,
    *,
    size: int | None = None,
) -> Labeller:
    """Check all predicates and make them one labeller.

    `fields` are the named slices [start, stop) of the observation; one of a single component is a
    number. Propositions keep the order of `predicates`, then come those only in `python`, whose
    values are `path/file.py:function`; a name in both is the Python one, so that an empty text in
    `predicates` can hold its place. With `size`, the fields must lie in observations of so many
    components.

    Raises CompileError with every finding: SPEC110 to SPEC120.
    """
    findings: list[Diagnostic] = []
    tests: dict[str, Test] = {}
    if size is not None:
        findings += [_outside(n, *ends, size) for n, ends in fields.items() if ends[1] > size]
    for name in dict.fromkeys([*predicates, *python]):
        try:
            if name in python:
                tests[name] = _batched(python_predicate(_source(python[name])))
            else:
                tests[name] = _compiled(_source(predicates[name]), fields)
        except CompileError as error:
            findings += error.diagnostics
    if findings:
        raise CompileError(*findings)
    return Labeller(tuple(tests), tuple(tests.values()))


def _source(text: SourceText | str) -> SourceText:
    return SourceText.plain(text, "<predicate>") if isinstance(text, str) else text


def _compiled(text: SourceText, fields: Mapping[str, tuple[int, int]]) -> Test:
    checker = Checker(text, fields)
    expression = checker.predicate(parse(text))
    if checker.findings:
        raise CompileError(*checker.findings)
    return expression.run


def _batched(function: Callable[[Array], NDArray[np.bool_]]) -> Test:
    """A function of [n, d] for observations with any leading axes."""

    def test(observations: Array) -> Array:
        flat = observations.reshape(-1, observations.shape[-1])
        return function(flat).reshape(observations.shape[:-1])

    return test


def _outside(name: str, start: int, stop: int, size: int) -> Diagnostic:
    components = counted(size, "component")
    return Diagnostic.of("SPEC120", name=name, start=start, stop=stop, size=components)
