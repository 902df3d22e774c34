"""Sizes and times of translations, in this process or, where memory counts, in one of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import ceil
from statistics import median
from time import process_time

from tiloilc.automaton import Acceptance, translate
from tiloilc.automaton.limits import MAX_STATES, TIMEOUT
from tiloilc.bench.automata.formulas import Known
from tiloilc.bench.automata.references import Reference
from tiloilc.diag import CompileError
from tiloilc.ltl import parse

RUNS = 3
"""Translations of each formula; the time told is their median."""


@dataclass(frozen=True, slots=True)
class Measured:
    """An automaton's states without the sink and its ε-jumps, or the code it ended in.

    `ms` is the median time of one translation, in milliseconds.
    """

    states: int
    jumps: int
    ms: float
    code: str | None = None


@dataclass(frozen=True, slots=True)
class Row:
    """One formula; `edge` and `state` are its automata with marked edges and accepting states."""

    name: str
    formula: str
    best: int | None
    edge: Measured
    state: Measured
    reference: Reference | None = None

    @property
    def is_above(self) -> bool:
        """Whether ours is larger than the best known one, or missing."""
        return self.best is not None and (
            self.edge.code is not None or self.edge.states > self.best
        )

    @property
    def is_below(self) -> bool:
        """Whether ours is smaller."""
        return self.best is not None and not self.is_above and self.edge.states < self.best


@dataclass(frozen=True, slots=True)
class Figures:
    """Times of many formulas, in milliseconds; no more than 1 % take longer than `late`."""

    median: float
    late: float
    longest: float

    @classmethod
    def of(cls, times: Iterable[float]) -> Figures:
        """The figures of one or more times (percentiles by nearest rank)."""
        ordered = sorted(times)
        assert ordered, "nothing was measured"
        return cls(median(ordered), ordered[ceil(0.99 * len(ordered)) - 1], ordered[-1])


@dataclass(frozen=True, slots=True)
class Alone:
    """A translation in a process of its own: `peak` is that process's memory, in MiB."""

    name: str
    formula: str
    measured: Measured
    peak: float


def measure(text: str, acceptance: Acceptance = "edge", runs: int = RUNS) -> Measured:
    """Translate the formula `text` so many times."""
    parsed = parse(text)
    times = []
    states, jumps, code = 0, 0, None
    for _ in range(runs):
        began = process_time()
        try:
            ldba = translate(parsed.formula, parsed.propositions, acceptance=acceptance)
            states, jumps = len(ldba.names) - (ldba.sink is not None), len(ldba.jumps)
        except CompileError as error:
            code = error.diagnostics[0].code
        times.append((process_time() - began) * 1000)
        if code is not None:
            break
    return Measured(states, jumps, median(times), code)


def measure_set(references: Iterable[Reference], runs: int = RUNS) -> Iterator[Row]:
    """Each formula of a table of published sizes."""
    for reference in references:
        text = reference.formula
        edge, state = measure(text, "edge", runs), measure(text, "state", 1)
        yield Row(reference.origin, text, reference.best, edge, state, reference)


def measure_known(formulas: Mapping[str, Known], runs: int = RUNS) -> Iterator[Row]:
    """Each of some named formulas."""
    for name, known in formulas.items():
        edge, state = measure(known.text, "edge", runs), measure(known.text, "state", 1)
        yield Row(name, known.text, known.best, edge, state)


def measure_alone(formulas: Mapping[str, str]) -> Iterator[Alone]:
    """Each of some named formulas once, with accepting states, by a Python that does nothing else.

    It is stopped when it is far beyond the translator's own time limit.
    """
    for name, text in formulas.items():
        command = [sys.executable, "-m", "tiloilc.bench.automata.alone", text]
        result = subprocess.run(command, capture_output=True, check=True, timeout=4 * TIMEOUT)
        found = json.loads(result.stdout)
        measured = Measured(found["states"], found["jumps"], found["ms"], found["code"])
        yield Alone(name, text, measured, found["peak"])


LIMITS = f"{MAX_STATES:,} states and {TIMEOUT:g} s"
"""What a translation may take before it ends in AUT305."""
