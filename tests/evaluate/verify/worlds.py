"""Small worlds with known probabilities, as models and as environments that roll the dice."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.spaces import Discrete
from numpy.typing import NDArray

from tests.properties.models import Mdp
from tiloilc.tasks import MarkovModel

STAY, PLAY = 0, 1
LAST = 4


def model(outcomes: list[list[list[tuple[float, int]]]], initial: list[float]) -> MarkovModel:
    """`outcomes[s][a]` are (probability, state); a state shows its number."""
    m = max(len(cell) for row in outcomes for cell in row)
    successor = np.zeros((len(outcomes), len(outcomes[0]), m), np.int64)
    probability = np.zeros(successor.shape)
    for s, row in enumerate(outcomes):
        for a, cell in enumerate(row):
            for i, (chance, after) in enumerate(cell):
                successor[s, a, i], probability[s, a, i] = after, chance
    return MarkovModel(
        np.arange(len(outcomes))[:, None],
        successor,
        probability,
        np.array(initial),
        np.arange(len(outcomes[0])),
        True,
        "by hand",
    )


def markov(mdp: Mdp) -> MarkovModel:
    """One of the property tests' processes; where it has fewer actions, the first is repeated."""
    most = max(map(len, mdp.actions))
    outcomes = [
        [[(float(p), t) for t, p in a.items()] for a in (*row, *[row[0]] * (most - len(row)))]
        for row in mdp.actions
    ]
    return model(outcomes, [1.0, *[0.0] * (len(outcomes) - 1)])


def gamble() -> MarkovModel:
    """A gambler's ruin: from 2, up with 3/4 and down with 1/4; 0 and 4 are never left.

    Who plays on comes to 4 with (1 - 1/9) / (1 - 1/81) = 9/10. Who stays, stays.
    """
    rows = []
    for s in range(LAST + 1):
        stays = [(1.0, s)]
        rows.append([stays, [(0.75, s + 1), (0.25, s - 1)] if 0 < s < LAST else stays])
    return model(rows, [0.0, 0.0, 1.0, 0.0, 0.0])


class Gamble(gym.Env[int, int]):
    """The gambler's ruin; a `liar` publishes that nobody ever loses."""

    def __init__(self, liar: bool = False, silent: bool = False) -> None:
        self.observation_space, self.action_space = Discrete(LAST + 1), Discrete(2)
        self.liar, self.silent, self.place = liar, silent, 2

    def markov_model(self) -> MarkovModel | None:
        if self.silent:
            return None
        found = gamble()
        if self.liar:
            found.probability[1:LAST, PLAY] = [1.0, 0.0]
        return found

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.place = 2
        return self.place, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        if action == PLAY and 0 < self.place < LAST:
            self.place += 1 if self.np_random.random() < 0.75 else -1
        return self.place, 0.0, False, False, {}


class Told:
    """The same decisions for every seed: an action for each observation, the k-th option."""

    def __init__(self, actions: list[int], option: int = 0) -> None:
        self.actions, self.option = np.array(actions), option

    def act(self, observations: NDArray[Any], states: NDArray[Any], greedy: bool) -> NDArray[Any]:
        assert greedy
        assert observations.shape[:2] == states.shape
        return np.asarray(self.actions[observations[..., 0].astype(np.int64)])

    def choose(self, observations: NDArray[Any], options: NDArray[Any], greedy: bool) -> Any:
        assert greedy
        return options[..., self.option]

    def policy(self) -> dict[str, Any]:
        raise NotImplementedError

    def fixed(self) -> dict[str, Any]:
        raise NotImplementedError

    def load_policy(self, state: dict[str, Any]) -> None:
        raise NotImplementedError


if "TestsGamble-v0" not in gym.registry:
    gym.register("TestsGamble-v0", entry_point=Gamble)
