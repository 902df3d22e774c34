"""The same without tiloilc, with numpy and onnxruntime alone: python drive_onnx.py EXPORT

Only the environment is tiloilc's here. The propositions are written by hand, as they would be on a
robot; the automaton and the order of the propositions stand in policy.json.
"""

import json
import sys
from pathlib import Path

import gymnasium
import numpy as np
import onnxruntime

import tiloilc.tasks  # noqa: F401  # registers the environment

LABELS = {
    "there": lambda x, y: x >= 7 and y == 0,
    "outside": lambda x, y: y != 0,
}

folder = Path(sys.argv[1])
about = json.loads((folder / "policy.json").read_text())
automaton = about["automaton"]
model = onnxruntime.InferenceSession(folder / about["model"]["file"])


def ask(observation, state):
    """The model's outputs by name: `action`, and `value` if the automaton has ε-jumps."""
    given = {"observation": np.float32([observation]), "state": np.array([state])}
    names = [output.name for output in model.get_outputs()]
    return {name: found[0] for name, found in zip(names, model.run(None, given), strict=True)}


def step(state, observation):
    """Where the automaton goes from `state` when it sees `observation`."""
    holds = [LABELS[proposition["name"]](*observation) for proposition in about["propositions"]]
    letter = sum(bit << i for i, bit in enumerate(holds))

    def matches(row):
        return row["state" if "state" in row else "source"] == state and any(
            letter & mask == value for mask, value in row["cubes"]
        )

    for option in filter(matches, automaton["options"]):  # this task has none
        return max(option["targets"], key=lambda b: ask(observation, b)["value"])
    return next(filter(matches, automaton["edges"]))["target"]


env = gymnasium.make("tiloilc/GridAvoid-v0", distance=7, max_episode_steps=17)
observation, _ = env.reset(seed=1)
state, visits, done = step(automaton["initial"], observation), 0, False
while not done:
    observation, _, terminated, truncated, _ = env.step(ask(observation, state)["action"])
    state = step(state, observation)
    visits += state in automaton["accepting"]
    done = terminated or truncated
print(f"accepting at {visits} of 17 steps{', then lost' if state == automaton['sink'] else ''}")
