"""Task files for the tests of the driver, made by changing one that has no findings."""

from pathlib import Path

SPEC = """\
name: task
environment:
  id: tiloilc/FlatWorld-v0
  horizon: 50
propositions:
  r: dist(pos, [0.45, -0.75]) < 0.3
  y: dist(pos, [-0.85, 0.15]) < 0.3
  b: norm(pos) < 0.8
formula: "G F r & G !y & G !b"
train:
  steps: 10_000
  seeds: 2
"""


def spec(folder: Path, *changes: tuple[str, str], name: str = "task.yaml") -> Path:
    """Write the task file with each `old` of `changes` replaced by `new`."""
    text = SPEC
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


ENVIRONMENT = """\
import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict


class Own(gymnasium.Env):
    observation_fields = {"second": slice(1, 3)}

    def __init__(self, seen=None):
        parts = {"speed": Box(-1, 1, (1,)), "place": Box(-2, 2, (2,))}
        self.observation_space = Dict(parts) if seen is None else seen
        self.action_space = Box(-1, 1, (1,))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return self.observation_space.sample(), {}

    def step(self, action):
        return self.observation_space.sample(), 0.0, False, False, {}


gymnasium.register("Own-v0", entry_point=Own)
"""
