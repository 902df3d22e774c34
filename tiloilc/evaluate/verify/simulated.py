"""Episodes of a policy or an expert as trials: no violation, and enough accepting visits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tiloilc.demos import DemoSet, play, replay_all
from tiloilc.diag import CompileError
from tiloilc.evaluate.rollout import Arena
from tiloilc.evaluate.seeds import EVALUATION
from tiloilc.evaluate.verify.told import Path
from tiloilc.learn import Labels, Policy
from tiloilc.plan import Plan
from tiloilc.product import Copies, Int

CHUNK = 20
"""Episodes that are played at once, as many copies of the environment for each agent."""


@dataclass(frozen=True, slots=True, eq=False)
class Trials:
    """What each agent achieved in its episodes.

    violated   bool [seed, episode], a step led into the sink, or the first label did
    visits     int [seed, episode, 2], steps to accepting states in each half of the time
    alike      bool [seed], all episodes of an agent passed the same automaton states
    """

    violated: NDArray[np.bool_]
    visits: Int
    alike: NDArray[np.bool_]

    def of(self, agents: list[int]) -> Trials:
        """Those of some agents alone."""
        return Trials(self.violated[agents], self.visits[agents], self.alike[agents])

    def fine(self, visits: int) -> NDArray[np.bool_]:
        """Who did not violate and came to acceptance so often, [seed, episode]."""
        return np.asarray(~self.violated & (self.visits.sum(axis=2) >= visits))

    def lasting(self) -> NDArray[np.bool_]:
        """Who did not violate and accepted in the second half of the time too, [seed, episode]."""
        return np.asarray(~self.violated & (self.visits[..., 1] > 0))


def in_halves(accepting: NDArray[np.bool_]) -> Int:
    """How many of the steps [seed, episode, T] are true in each half: [seed, episode, 2]."""
    half = accepting.shape[2] // 2
    parts = (accepting[..., :half], accepting[..., half:])
    return np.stack([part.sum(axis=2) for part in parts], axis=2)


class Simulation:
    """The agents of a run in evaluation episodes, whose seeds training never uses.

    No two trials share an episode, so that those of all agents together are independent, too.
    """

    def __init__(
        self,
        plan: Plan,
        labels: Labels,
        policy: Policy,
        episodes: int,
        copies: type[Copies] = Copies,
    ) -> None:
        self.plan, self.labels, self.policy = plan, labels, policy
        self.episodes, self.chunk = episodes, min(episodes, CHUNK)
        self.arena = Arena(plan, labels, self.chunk, copies)

    def play(self) -> Trials:
        """All episodes. Raises CompileError RUN707 if the environment fails."""
        violated, visits = [], []
        first, alike = None, np.ones(self.plan.train.seeds, np.bool_)
        for start in range(0, self.episodes, self.chunk):
            rollout = self.arena.play(self.policy, self._seeds(start, self.chunk))
            kept = min(self.chunk, self.episodes - start)
            violated.append(np.asarray(rollout.sink[:, :kept].any(axis=2)))
            visits.append(in_halves(rollout.accepting[:, :kept, 1:]))
            path: Int = np.where(rollout.over, -1, rollout.states)[:, :kept]
            first = path[:, :1] if first is None else first
            alike &= np.array(
                [bool((one == same).all()) for one, same in zip(path, first, strict=True)]
            )
        return Trials(np.concatenate(violated, 1), np.concatenate(visits, 1), alike)

    def path(self, agent: int, episode: int) -> Path:
        """Episode number `episode` of the agent in place `agent`, played once more and alone."""
        alone = Arena(self.plan, self.labels, 1)
        rollout = alone.play(self.policy, self._seeds(episode, 1))
        lived = ~rollout.over[agent, 0]
        states, seen = rollout.states[agent, 0][lived], rollout.observations[agent][lived]
        return Path(seen, self.labels(seen), states, None)

    def _seeds(self, start: int, count: int) -> list[int]:
        """The seeds of `count` episodes from number `start` on, of each agent.

        What a last chunk has beyond the last episode is played and not counted.
        """
        each = -(-self.episodes // self.chunk) * self.chunk
        agents = range(self.plan.train.seeds)
        return [EVALUATION + i * each + start + j for i in agents for j in range(count)]


def expert_trials(plan: Plan, labels: Labels, expert: str, episodes: int) -> Trials:
    """The episodes of one expert as trials, [1, episode]: without noise, where that can be had.

    At ε-jumps they are read in their own favour. Raises CompileError DEMO506 or DEMO509 if there is
    no such expert.
    """
    made = plan.environment
    seeds = range(EVALUATION, EVALUATION + episodes)
    try:
        played = play(
            made.id, made.kwargs, horizon=made.horizon, expert=expert, seeds=seeds, noise=0.0
        )
    except CompileError as error:
        if all(diagnostic.code != "DEMO509" for diagnostic in error.diagnostics):
            raise
        played = play(made.id, made.kwargs, horizon=made.horizon, expert=expert, seeds=seeds)
    runs = replay_all(DemoSet(played), labels, plan.ldba)[1]
    violated = np.array([[run.violates_at is not None for run in runs]])
    accepting = np.zeros((1, episodes, made.horizon), np.bool_)
    for row, run in zip(accepting[0], runs, strict=True):
        row[: len(run.states) - 1] = np.isin(run.states[1:], sorted(plan.ldba.accepting))
    first = runs[0].states
    alike = all(np.array_equal(run.states, first) for run in runs)
    return Trials(violated, in_halves(accepting), np.array([alike]))
