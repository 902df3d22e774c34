"""Verification of what a run left, and of a task alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from tiloilc.demos import DemoSet
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate.protocol import require_finished
from tiloilc.evaluate.rollout import EndlessCopies
from tiloilc.evaluate.verify import told
from tiloilc.evaluate.verify.bounds import clopper_pearson, trials_needed
from tiloilc.evaluate.verify.chain import decisions, induced_chain
from tiloilc.evaluate.verify.counterexample import Failure, failure
from tiloilc.evaluate.verify.exact import exactly, maximum
from tiloilc.evaluate.verify.models import model_of
from tiloilc.evaluate.verify.results import (
    Counterexample,
    Judged,
    Sampled,
    Simulated,
    Verification,
    Walked,
)
from tiloilc.evaluate.verify.simulated import Simulation, Trials, expert_trials
from tiloilc.evaluate.verify.storm import Ask, Storm, Unanswered, has_storm, require_storm
from tiloilc.learn import Agent, Labels, load_policy, make_loop
from tiloilc.plan import Plan
from tiloilc.product import walk_tables

if TYPE_CHECKING:
    from tiloilc.tasks import MarkovModel

Method = Literal["auto", "exact", "simulate"]
Tell = Callable[[str], None]

EPISODES = 100
"""Trials of each agent, unless told otherwise: with all of them fine, 0.96 at least."""

HALF_WIDTH = 0.05
"""Of which it is told how many trials it needs, unless told otherwise."""


TIME_LIMIT = 600.0
"""Seconds that Storm has for each question, unless told otherwise."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is to be verified, and how. `seed` is one agent of the run's, None all of them.

    Without `episodes` there are as many as `half_width` needs whatever comes, or EPISODES.
    `time_limit` [s] is for each of Storm's answers. Beside what is exact each agent walks `steps`
    steps as often, if there are any.
    """

    policy: str = "best"
    method: Method = "auto"
    seed: int | None = None
    episodes: int | None = None
    confidence: float = 0.95
    half_width: float | None = None
    visits: int = 1
    time_limit: float = TIME_LIMIT
    steps: int | None = None

    @property
    def trials(self) -> int:
        """Episodes of each agent."""
        if self.episodes is None and self.half_width is not None:
            return trials_needed(0.5, self.half_width, self.confidence) or EPISODES
        return self.episodes or EPISODES


def verify_task(
    plan: Plan, labels: Labels, expert: str | None, wanted: Wanted, tell: Tell = lambda text: None
) -> Verification:
    """The most that any policy could reach, and what an expert does where that is not exact.

    Raises CompileError RUN713 without Storm, RUN714 if the environment belies its model.
    """
    model, why = model_of(plan)
    best, about = None, None
    if model is not None:
        require_storm(plan.name)
        with _storm(plan.name, wanted) as ask:
            best = maximum(model, labels(model.seen), plan, ask)
    if why and expert is not None:
        tell(f"playing {wanted.trials} episodes of the expert `{expert}`")
        trials = expert_trials(plan, labels, expert, wanted.trials)
        about = _about(plan, trials, wanted, ())
    named = "" if about is None else expert or ""
    return Verification(plan, "", (), about, best, (), why, named)


def verify_run(
    plan: Plan,
    demos: DemoSet,
    labels: Labels,
    run: Path,
    wanted: Wanted,
    tell: Tell = lambda text: None,
) -> Verification:
    """How likely the greedy policies of the run in the folder `run` satisfy their formula.

    Raises CompileError RUN706 if the run is not finished, RUN708 if it has no such policy or agent,
    RUN713 if it cannot be done exactly and should, RUN714 if the environment belies its model.
    """
    agent, places = _agent(plan, demos, labels, run, wanted)
    model, why = model_of(plan)
    if why and (wanted.method == "exact" or wanted.steps is not None):
        option = "--method exact" if wanted.method == "exact" else "--walk"
        help = f"leave out {option}: probabilities are bounded by simulation then"
        about = Diagnostic.of("RUN713", subject=run.as_posix(), problem=why, help=help)
        raise CompileError(about)
    if not why and wanted.method != "simulate":
        assert model is not None
        require_storm(run.as_posix())
        with _storm(run.as_posix(), wanted) as ask:
            known = _exactly(plan, labels, agent, model, wanted, places, ask)
        if wanted.steps is None:
            return known
        tell(f"walking {wanted.steps:,} steps {wanted.trials} times with each agent")
        return _walked(known, plan, labels, agent, wanted.steps, wanted, places)
    best = None
    if model is not None and has_storm():
        with suppress(Unanswered), Storm(wanted.time_limit) as storm:
            best = maximum(model, labels(model.seen), plan, storm.probabilities)
    tell(f"playing {wanted.trials} episodes of each of {len(places)} agents")
    why = why or "simulation was asked for"
    return replace(_simulated(plan, labels, agent, wanted, places), maximum=best, why=why)


@contextmanager
def _storm(subject: str, wanted: Wanted) -> Iterator[Ask]:
    """Storm to be asked; raises CompileError RUN713 where it has no answer."""
    try:
        with Storm(wanted.time_limit) as storm:
            yield storm.probabilities
    except Unanswered as error:
        help = "bound a run's policies with --method simulate, or give Storm a longer --time-limit"
        about = Diagnostic.of("RUN713", subject=subject, problem=str(error), help=help)
        raise CompileError(about) from error


def _exactly(
    plan: Plan,
    labels: Labels,
    agent: Agent,
    model: MarkovModel,
    wanted: Wanted,
    places: list[int],
    ask: Ask,
) -> Verification:
    """Each agent's chain, by Storm."""
    letters, walk = labels(model.seen), walk_tables(plan.ldba, plan.train.epsilon)
    decided = decisions(agent, model, letters, walk, plan.train.seeds)
    judged, failures = [], []
    for place in places:
        chain = induced_chain(model, letters, walk, decided.columns[place], decided.arrivals[place])
        found = exactly(chain, plan, ask)
        judged.append(Judged(plan.train.first_seed + place, found))
        failed = None if found.probability == 1 else failure(chain, model, plan)
        if failed is not None:
            failures.append((found.probability, _told(plan, judged[-1].seed, failed)))
    failures.sort(key=lambda entry: (entry[0], entry[1].seed))
    best = maximum(model, letters, plan, ask)
    shown = tuple(counterexample for _, counterexample in failures)
    return Verification(plan, wanted.policy, tuple(judged), None, best, shown)


def _walked(
    known: Verification,
    plan: Plan,
    labels: Labels,
    agent: Agent,
    steps: int,
    wanted: Wanted,
    places: list[int],
) -> Verification:
    """What is known exactly, beside long walks in the environment itself, which stay at its end."""
    longer = replace(plan, environment=plan.environment.model_copy(update={"horizon": steps}))
    trials = Simulation(longer, labels, agent, wanted.trials, EndlessCopies).play().of(places)
    rows = zip(known.judged, trials.lasting(), trials.violated, strict=True)
    judged = tuple(
        replace(one, walked=_sampled(fine, violated, wanted.confidence))
        for one, fine, violated in rows
    )
    about = Walked(wanted.confidence, wanted.trials, steps)
    return replace(known, judged=judged, walked=about)


def _told(plan: Plan, seed: int, failed: Failure) -> Counterexample:
    path = failed.path
    if path.lost(plan.ldba) is not None:
        reason = told.violation(path, plan)
    else:
        reason = told.repetition(path, plan, failed.nodes)
    return Counterexample(seed, path, tuple(told.way(path, plan)), reason, failed.probability)


def _simulated(
    plan: Plan, labels: Labels, agent: Agent, wanted: Wanted, places: list[int]
) -> Verification:
    """Each agent's trials, and those of all."""
    simulation = Simulation(plan, labels, agent, wanted.trials)
    trials = simulation.play().of(places)
    fine = trials.fine(wanted.visits)
    sampled = [_sampled(*row, wanted.confidence) for row in zip(fine, trials.violated, strict=True)]
    seeds = tuple(plan.train.first_seed + place for place in places)
    about = _about(plan, trials, wanted, seeds)
    judged = tuple(Judged(seed, found) for seed, found in zip(seeds, sampled, strict=True))
    shown = _shown(simulation, plan, trials, wanted, places)
    return Verification(plan, wanted.policy, judged, about, None, shown)


def _about(plan: Plan, trials: Trials, wanted: Wanted, seeds: tuple[int, ...]) -> Simulated:
    """How trials were made, all of them together, and how many there should be."""
    pooled = _sampled(trials.fine(wanted.visits), trials.violated, wanted.confidence)
    half_width = wanted.half_width or HALF_WIDTH
    return Simulated(
        wanted.confidence,
        wanted.trials,
        plan.environment.horizon,
        wanted.visits,
        pooled,
        half_width,
        trials_needed(0.5, half_width, wanted.confidence),
        trials_needed(pooled.rate, half_width, wanted.confidence),
        bool(trials.alike.all()),
        tuple(seed for seed, alike in zip(seeds, trials.alike, strict=bool(seeds)) if alike),
    )


def _sampled(fine: NDArray[np.bool_], violated: NDArray[np.bool_], confidence: float) -> Sampled:
    successes, trials = int(fine.sum()), fine.size
    lost = int(violated.sum())
    bounds = clopper_pearson(successes, trials, confidence)
    return Sampled(successes, lost, trials, bounds, clopper_pearson(lost, trials, confidence))


def _shown(
    simulation: Simulation, plan: Plan, trials: Trials, wanted: Wanted, places: list[int]
) -> tuple[Counterexample, ...]:
    """An episode in which the agent that does worst fails, if it fails once more."""
    fine = trials.fine(wanted.visits)
    worst = int(fine.mean(axis=1).argmin())
    failed = np.flatnonzero(~fine[worst])
    if not len(failed):
        return ()
    violated = failed[trials.violated[worst][failed]]  # of two kinds the clearer one
    episode = int((violated if len(violated) else failed)[0])
    path = simulation.path(places[worst], episode)
    seed, way = plan.train.first_seed + places[worst], tuple(told.way(path, plan))
    visits = int(np.isin(path.states[1:], sorted(plan.ldba.accepting)).sum())
    if path.lost(plan.ldba) is not None:
        reason = told.violation(path, plan)
    elif visits < wanted.visits:
        reason = told.shortfall(path, plan, visits, wanted.visits)
    else:
        return ()  # the environment does not repeat itself
    return (Counterexample(seed, path, way, reason, None),)


def _agent(
    plan: Plan, demos: DemoSet, labels: Labels, run: Path, wanted: Wanted
) -> tuple[Agent, list[int]]:
    """The agents with the policies wanted, and the places of those that are verified."""
    require_finished(run)
    policy = load_policy(run, wanted.policy)
    first, count = plan.train.first_seed, plan.train.seeds
    problem = ""
    if policy is None:
        problem = f"it has no `{wanted.policy}`"
    elif wanted.seed is not None and not first <= wanted.seed < first + count:
        problem = f"it has the seeds {first} to {first + count - 1}, not {wanted.seed}"
    if policy is None or problem:
        raise CompileError(Diagnostic.of("RUN708", path=run.as_posix(), problem=problem))
    agent = make_loop(plan, demos, labels).agent
    agent.load_policy(policy)
    return agent, list(range(count)) if wanted.seed is None else [wanted.seed - first]
