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
from tiloilc.product import Int

CHUNK = 20
"""Episodes that are played at once, as many copies of the environment for each agent."""


@dataclass(frozen=True, slots=True, eq=False)
class Trials:
    """What each agent achieved in the same episodes, [seed, episode].

    `violated`: a step led into the sink, or the first label did. `visits` counts accepting states
    that steps led to. `alike`: all episodes of an agent passed the same automaton states.
    """

    violated: NDArray[np.bool_]
    visits: Int
    alike: NDArray[np.bool_]

    def of(self, agents: list[int]) -> Trials:
        """Those of some agents alone."""
        return Trials(self.violated[agents], self.visits[agents], self.alike[agents])

    def fine(self, visits: int) -> NDArray[np.bool_]:
        """Who did not violate and came to acceptance so often, [seed, episode]."""
        return ~self.violated & (self.visits >= visits)


class Simulation:
    """The agents of a run in evaluation episodes, whose seeds training never uses.

    No two trials share an episode, so that those of all agents together are independent, too.
    """

    def __init__(self, plan: Plan, labels: Labels, policy: Policy, episodes: int) -> None:
        self.plan, self.labels, self.policy = plan, labels, policy
        self.episodes, self.chunk = episodes, min(episodes, CHUNK)
        self.arena = Arena(plan, labels, self.chunk)

    def play(self) -> Trials:
        """All episodes. Raises CompileError RUN707 if the environment fails."""
        violated, visits = [], []
        first, alike = None, np.ones(self.plan.train.seeds, np.bool_)
        for start in range(0, self.episodes, self.chunk):
            rollout = self.arena.play(self.policy, self._seeds(start, self.chunk))
            kept = min(self.chunk, self.episodes - start)
            violated.append(np.asarray(rollout.sink[:, :kept].any(axis=2)))
            visits.append(rollout.accepting[:, :kept, 1:].sum(axis=2))
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
    visits = np.array([[run.visits for run in runs]])
    first = runs[0].states
    alike = all(np.array_equal(run.states, first) for run in runs)
    return Trials(violated, visits, np.array([alike]))
