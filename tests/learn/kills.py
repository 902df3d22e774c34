"""Runs that are killed at random moments, and gone on with, beside runs that never were.

    python -m tests.learn.kills --moments 20 --seed 0

trains a task on a table, one with SAC and one with SAC compiled, kills each with SIGKILL at random
moments after its run folder was made, resumes it, and compares its events and policies byte by byte
with those of the uninterrupted run.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


def grid_task(name: str, steps: int, checkpoint_every: int, every: int) -> str:
    """A small task on a table."""
    return f"""\
name: {name}
environment:
  id: tiloilc/GridCircular-v0
  kwargs: {{zones: 2}}
  horizon: 12
propositions:
  a: 15 <= x <= 19 and 8 <= y <= 12
  b: 8 <= x <= 12 and 15 <= y <= 19
  z: 7 <= x <= 13 and 7 <= y <= 13
formula: "G F (a & X F b) & G !z"
demonstrations: {{source: expert, count: 2, max_visits: 1, actions: inferred}}
train: {{steps: {steps}, seeds: 2, learning_starts: 20, checkpoint_every: {checkpoint_every}}}
evaluate: {{episodes: 2, every: {every}}}
"""


TABLE = grid_task("table", 1500, 50, 500)

SAC = """\
name: sac
environment: {id: tiloilc/FlatWorld-v0, horizon: 12}
propositions:
  y: dist(pos, [-0.85, 0.15]) < 0.3
  b: norm(pos) < 0.8
formula: "F G y & G !b"
demonstrations: {source: expert, count: 2, actions: inferred}
train:
  steps: 400
  seeds: 2
  learning_starts: 60
  checkpoint_every: 20
  buffer_size: 150
  actor_hidden: [16]
  critic_hidden: [16]
  batch_size: 16
  warm_start: none
evaluate: {episodes: 2, every: 200}
"""

COMPILED = SAC.replace("name: sac", "name: compiled").replace("train:", "train:\n  compile: always")

TASKS = {"table": TABLE, "sac": SAC, "compiled": COMPILED}


@dataclass(frozen=True)
class Killed:
    """What became of one run: how long it lived, where it went on, and whether it ended alike."""

    after: float
    resumed: str
    alike: bool


class Task:
    """A compiled task in a folder, and what its uninterrupted run left."""

    def __init__(self, folder: Path, text: str) -> None:
        self.folder = folder
        folder.mkdir()
        (folder / "task.yaml").write_text(text, encoding="utf-8")
        self.call("compile", "task.yaml", "-o", "build", "-q")
        self.call("train", "build", "-q", "--runs", "first")  # what is compiled is kept
        self.whole = folder / "whole" / folder.name / "0001"
        process, began = self.train(self.whole), time.monotonic()
        assert process.wait(timeout=300) == 0
        self.seconds = time.monotonic() - began

    def kills(self, moments: int, rng: random.Random) -> Iterator[Killed]:
        """One run for each moment, even parts of a run's life apart and shifted at random."""
        for k in range(moments):
            yield self.kill((k + rng.random()) / moments * self.seconds)

    def train(self, run: Path) -> subprocess.Popen[bytes]:
        """A program that trains, as soon as its run folder is there."""
        runs = run.parents[1]
        process = subprocess.Popen(
            command("train", "build", "-q", "--runs", runs.name),
            cwd=self.folder,
            env=environment(),
            stdout=subprocess.DEVNULL,
        )
        while not (run / "plan.json").exists():
            assert process.poll() is None
            time.sleep(0.005)
        return process

    def kill(self, after: float) -> Killed:
        """Train, kill after so many seconds, resume."""
        runs = self.folder / f"runs{after:.6f}"
        run = runs / self.folder.name / "0001"
        process = self.train(run)
        try:
            process.wait(timeout=after)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
        assert process.wait(timeout=60) in (0, -signal.SIGKILL)
        said = self.call("train", run.as_posix(), "--resume").stderr
        resumed = next(line for line in said.splitlines() if line.startswith(("going", "begin")))
        alike = left_by(run) == left_by(self.whole)
        shutil.rmtree(runs)
        return Killed(after, resumed, alike)

    def call(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """The command line, which must succeed."""
        done = subprocess.run(
            command(*arguments), cwd=self.folder, env=environment(), capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done


def left_by(run: Path) -> dict[str, bytes]:
    """Events and policies."""
    paths = [run / "events.jsonl", *sorted((run / "checkpoints").glob("[a-z]*.safetensors"))]
    assert len(paths) >= 3, paths
    return {path.name: path.read_bytes() for path in paths}


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "tiloilc", *arguments]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT)}


def say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--moments", type=int, default=20, help="kills of each task")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng, wrong = random.Random(given.seed), 0
    with tempfile.TemporaryDirectory() as folder:
        for name, text in TASKS.items():
            task = Task(Path(folder) / name, text)
            say(f"{name}: {task.seconds:.1f} s without interruption")
            for killed in task.kills(given.moments, rng):
                wrong += not killed.alike
                verdict = "alike" if killed.alike else "NOT ALIKE"
                say(f"  killed after {killed.after:5.2f} s: {killed.resumed}: {verdict}")
    kills = len(TASKS) * given.moments
    say(f"{kills - wrong} of {kills} ended as if never killed")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
