"""How long the everyday commands take in a fresh process, and whether they import torch."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from tiloilc.bench.contestants.work import Work
from tiloilc.bench.measurement import Measurement, Spread
from tiloilc.bench.turns import ONE_THREAD, Tell

SPEC = Work("flatworld_cycle").path

COMMANDS = {
    "tiloilc --help": (["--help"], 0.4),
    "tiloilc lint": (["lint", str(SPEC)], 1.5),
    "tiloilc compile": (["compile", str(SPEC), "-o"], 3.0),
}
"""Each with the most seconds it may take; the last is told a folder."""

IMPORTED = re.compile(rb"^import time:.*\| *torch *$", re.MULTILINE)


def measure(rounds: int, tell: Tell) -> list[Measurement]:
    """The rows of this benchmark; the first round warms the disk and is not counted."""
    rows = []
    with TemporaryDirectory() as folder:
        for name, (given, goal) in COMMANDS.items():
            arguments = [*given, str(Path(folder) / "build")] if given[-1] == "-o" else given
            seconds = [_seconds(arguments) for _ in range(rounds + 1)][1:]
            tell(f"{name}: {min(seconds):.2f} s")
            rows.append(Measurement(f"{name}, cold", Spread.of(seconds), "s", goal=goal))
            imports = len(IMPORTED.findall(_run(["-X", "importtime"], arguments)))
            rows.append(Measurement(f"{name} imports torch", Spread.of([imports]), "times", goal=0))
    return rows


def _seconds(arguments: list[str]) -> float:
    began = perf_counter()
    _run([], arguments)
    return perf_counter() - began


def _run(options: list[str], arguments: list[str]) -> bytes:
    """What the command tells on standard error."""
    command = [sys.executable, *options, "-m", "tiloilc", *arguments]
    done = subprocess.run(command, env=os.environ | ONE_THREAD, capture_output=True, check=True)
    return done.stderr
