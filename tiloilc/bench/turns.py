"""Contestants side by side: a process each, one pinned core, one thread, turn and turn about."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from math import ceil
from platform import python_version
from tempfile import TemporaryFile
from types import TracebackType
from typing import TypeAlias

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement, Spread

ROUNDS, SECONDS = 15, 0.5
"""Turns of each contestant, and how long one lasts."""

Tell: TypeAlias = Callable[[str], None]
"""Takes a line of talk."""

PIECES = 64
"""The least work of a turn; all turns are multiples of it."""

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
    "JAX_PLATFORMS": "cpu",
    "CUDA_VISIBLE_DEVICES": "",
}
"""What libraries are told, so that each has one thread, on the processor."""


@dataclass(frozen=True, slots=True)
class Contestant:
    """Who takes part: a function of a module of `contestants`, and its work.

    `each` is how many pieces of work it counts as when one is done: seeds of a stacked update.
    """

    title: str
    module: str
    function: str
    work: Work = field(default_factory=Work)
    each: int = 1


@dataclass(frozen=True, slots=True)
class Share:
    """Part of an update: milliseconds in `operation`, in so many calls."""

    operation: str
    ms: float
    calls: float


@dataclass(frozen=True, slots=True)
class Rates:
    """Pieces of work per second of processor time, a number a round; none if one is `missing`."""

    title: str
    per_second: tuple[float, ...]
    missing: str | None = None


def take_turns(
    contestants: Sequence[Contestant],
    rounds: int = ROUNDS,
    seconds: float = SECONDS,
    *,
    tell: Tell,
) -> list[Rates]:
    """Measure the contestants A B C A B C …; each has warmed up before the first round."""
    with ExitStack() as stack:
        running = [stack.enter_context(_Child(c)) for c in contestants]
        pieces = []
        for child in running:
            pieces.append(child.warm_up(seconds) if child.missing is None else 0)
            missing = f"{child.missing} is not installed" if child.missing else "ready"
            tell(f"{child.title}: {missing}")
        found: list[list[float]] = [[] for _ in running]
        for _ in range(rounds):
            for child, count, rates in zip(running, pieces, found, strict=True):
                if child.missing is None:
                    rates.append(child.each * count / child.seconds(count))
        return [
            Rates(child.title, tuple(rates), child.missing)
            for child, rates in zip(running, found, strict=True)
        ]


def compare(
    name: str, unit: str, ours: Rates, theirs: Rates, goal: float | None = None
) -> Measurement:
    """A row: the ratio is taken round by round, between turns that follow each other."""
    value = Spread.of(ours.per_second) if ours.per_second else None
    if (missing := ours.missing or theirs.missing) is not None:
        against = f"{theirs.title} ({missing} is not installed)"
        return Measurement(name, value, unit, against, goal=goal)
    pairs = zip(ours.per_second, theirs.per_second, strict=True)
    ratio = Spread.of([mine / other for mine, other in pairs])
    return Measurement(name, value, unit, theirs.title, Spread.of(theirs.per_second), ratio, goal)


def ask(module: str, work: Work) -> str:
    """What a module of `contestants` prints about `work`, in a process of its own."""
    command = [sys.executable, "-m", f"tiloilc.bench.contestants.{module}", work.to_json()]
    environment = os.environ | ONE_THREAD
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout


def profile(work: Work) -> list[Share]:
    """Where the time of our update goes."""
    return [Share(*row) for row in json.loads(ask("profile", work))]


def versions() -> dict[str, str]:
    """What was measured, as far as it is installed."""
    found = {}
    for name in ("tiloilc", "torch", "stable-baselines3", "sbx-rl", "jax", "gymnasium", "mujoco"):
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return {"Python": python_version(), **found}


class _Child:
    """A contestant's process, which waits while others have their turn."""

    def __init__(self, contestant: Contestant) -> None:
        self.title, self.each = contestant.title, contestant.each
        command = [sys.executable, "-m", "tiloilc.bench.contestants"]
        command += [contestant.module, contestant.function, contestant.work.to_json()]
        self.talk = TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115  # until the end
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.talk,
            text=True,
            env={**os.environ, **ONE_THREAD},
        )
        self.missing: str | None = json.loads(self._read()).get("missing")

    def __enter__(self) -> _Child:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end()

    def seconds(self, count: int) -> float:
        """Do `count` pieces of the work; how long it took."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{count}\n")
        self.process.stdin.flush()
        return float(self._read())

    def warm_up(self, seconds: float) -> int:
        """Work until times are steady; how many pieces take about so many seconds."""
        count = PIECES
        self.seconds(count)  # compiles
        while (took := self.seconds(count)) < seconds / 4:
            count *= 2
        return PIECES * ceil(count * seconds / took / PIECES)

    def _read(self) -> str:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            self.talk.seek(0)
            told = self.talk.read()
            self._end()
            raise RuntimeError(f"{self.title} has died:\n{told}")
        return line

    def _end(self) -> None:
        self.process.kill()
        self.process.communicate()
        self.talk.close()
