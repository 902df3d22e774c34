"""What can be said of a run in numbers and in one sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tiloilc.evaluate import (
    METRICS,
    Summary,
    area_under_curve,
    difference,
    generator,
    probability_of_improvement,
    steps_to_threshold,
    summarise,
)
from tiloilc.plan import Plan
from tiloilc.report.markup import number
from tiloilc.report.results.methods import method_name
from tiloilc.report.runs.reading import Floats
from tiloilc.report.runs.run import Occupancy, Run, Trajectories

__all__ = [
    "METRIC_TEXTS",
    "MetricText",
    "algorithm",
    "area",
    "better",
    "cloned",
    "cloning",
    "efficiency",
    "greedy",
    "labels",
    "occupancy",
    "optimum",
    "optimum_name",
    "percent",
    "summary",
    "trajectories",
    "verdict",
]

VISITS = "accepting_visits"

GOOD_ENOUGH = 0.9
"""Sample efficiency is told by the steps to this share of the optimum (measuring.md)."""

CLONING = "Behaviour cloning"


@dataclass(frozen=True)
class MetricText:
    """How a metric is named and its values are written."""

    title: str
    unit: str
    about: str
    share: bool = False

    def show(self, value: float) -> str:
        """A value as the page writes it."""
        if np.isnan(value):
            return "–"
        return f"{percent(value)} %" if self.share else f"{value:.2f}"


def percent(share: float) -> str:
    """A share in hundredths, with one place if it needs one."""
    return f"{share * 100:.1f}".removesuffix(".0")


METRIC_TEXTS = {
    VISITS: MetricText(
        "Accepting visits",
        "visits per episode",
        "steps of an episode that arrive in an accepting state of the automaton, undiscounted",
    ),
    "eventual_return": MetricText(
        "Eventual return",
        "return",
        "the sum over visits of γ to the number of visits before (Eq. 17 and 18)",
    ),
    "violation_rate": MetricText(
        "Violations",
        "share of episodes",
        "episodes that enter the sink, where the formula can no longer be satisfied",
        share=True,
    ),
    "success": MetricText(
        "Success",
        "share of episodes",
        "episodes with at least one accepting visit",
        share=True,
    ),
    "first_visit": MetricText(
        "First visit",
        "environment steps",
        "steps until the first accepting visit, over the episodes that have one",
    ),
}
assert tuple(METRIC_TEXTS) == METRICS


def greedy(run: Run) -> dict[str, Floats]:
    """The greedy policies' metrics: from eval.json, else from the last evaluation in training."""
    if run.final is not None and "greedy" in run.final.policies:
        return run.final.policies["greedy"]
    return {name: column[-1] for name, column in run.curve.values.items() if len(column)}


def cloning(run: Run) -> dict[str, Floats]:
    """Cloning alone: from eval.json, else of an unfinished run the evaluation at which learning
    began after it."""
    if run.final is not None:
        return run.final.policies.get("cloning", {})
    if run.plan is None or run.plan.train.warm_start == "none" or not _shown(run.plan):
        return {}
    begun = run.plan.train.learning_starts
    if begun not in run.curve.steps:
        return {}
    place = run.curve.steps.index(begun)
    return {name: column[place] for name, column in run.curve.values.items()}


def _shown(plan: Plan) -> bool:
    """Whether there are demonstrations."""
    given = plan.demonstrations
    return any((given.source, given.file, given.minari))


def occupancy(run: Run, states: int) -> Occupancy | None:
    """Where training time went, if the log tells of an automaton of so many states."""
    known = run.occupancy
    return None if known is None or known.shares.shape[1] != states else known


def trajectories(run: Run, states: int) -> Trajectories | None:
    """The episodes, if they are of an automaton of so many states."""
    known = run.trajectories
    return None if known is None or int(known.states.max()) >= states else known


def summary(values: Floats | None) -> Summary | None:
    """Statistics over seeds; the generator is new each time, so that order has no influence."""
    return None if values is None else summarise(values, generator())


def optimum(run: Run) -> float | None:
    """The greatest number of accepting visits in an episode, if it or a lower bound is known."""
    return None if run.final is None else run.final.optimum


def optimum_name(run: Run) -> str:
    """What `optimum` is: a lower bound is only the best known."""
    return "optimum" if run.final is not None and run.final.optimum_exact else "best known"


def efficiency(run: Run) -> tuple[float, int | None] | None:
    """(threshold, step): where the mean over seeds first reaches 90 % of `optimum`."""
    best = optimum(run)
    if best is None or best <= 0 or VISITS not in run.curve.values:
        return None
    threshold = GOOD_ENOUGH * best
    return threshold, steps_to_threshold(run.curve.steps, run.curve.values[VISITS], threshold)


def area(run: Run) -> Summary | None:
    """The mean height of the curve of accepting visits over training, by seed."""
    values = run.curve.values.get(VISITS)
    if values is None or len(values) < 2 or np.isnan(values).any():
        return None
    return summary(area_under_curve(run.curve.steps, values))


def cloned(run: Run, metric: str) -> float | None:
    """The mean of cloning alone in one metric."""
    over = summary(cloning(run).get(metric))
    return None if over is None else over.mean


def algorithm(run: Run) -> str:
    """The algorithm's name as people write it."""
    return CLONING if run.algorithm == "cloning" else method_name(run.algorithm)


def verdict(run: Run) -> str:
    """The result with its interval, optimum and cloning beside it: a sentence less its subject."""
    values = greedy(run)
    visits = summary(values.get(VISITS))
    if visits is None:
        return "has not been evaluated yet, so there is no result to report."
    low, high = visits.mean_interval.low, visits.mean_interval.high
    seeds = f"{visits.count} seed{'' if visits.count == 1 else 's'}"
    spread = f"95 % interval {low:.2f}–{high:.2f}, {seeds}" if visits.count > 1 else seeds
    if visits.count > 1 and low == high:
        spread = f"the same on all {seeds}"
    said = f"makes {visits.mean:.2f} accepting visits per episode ({spread})"
    best, begun = optimum(run), cloned(run, VISITS)
    beside = []
    if best is not None and best > 0:
        share = f"{visits.mean / best * 100:.0f} %"
        beside.append(f"{share} of the {optimum_name(run)} ({number(best)})")
    if begun is not None:
        beside.append(f"cloning alone makes {begun:.2f}")
    said += f": {'; '.join(beside)}." if beside else "."
    violations = summary(values.get("violation_rate"))
    if violations is not None:
        if violations.mean == 0:
            said += " No episode violates the formula."
        else:
            said += f" It violates the formula in {percent(violations.mean)} % of episodes."
    return said.replace(" %", "\u00a0%")


def better(run: Run, other: Run) -> tuple[str, str] | None:
    """(more visits, how likely a seed has more) than another run, both with intervals, as text."""
    mine, theirs = (greedy(one).get(VISITS) for one in (run, other))
    if mine is None or theirs is None or not len(mine) or not len(theirs):
        return None
    if np.isnan(mine).any() or np.isnan(theirs).any():
        return None
    gap, around = difference(theirs, mine, generator())
    likely, between = probability_of_improvement([(mine, theirs)], generator())
    return (
        f"{gap:+.2f} [{around.low:+.2f}, {around.high:+.2f}]",
        f"{likely:.2f} [{between.low:.2f}, {between.high:.2f}]",
    )


def labels(runs: Sequence[Run]) -> list[str]:
    """A short name for each run, by what tells them apart; equal ones get their folder's name."""
    parts: list[list[str]] = [[] for _ in runs]
    for values in (
        [run.name for run in runs],
        [algorithm(run) for run in runs],
        [run.preset for run in runs],
        _changes(runs),
    ):
        if len(set(values)) > 1:
            for part, value in zip(parts, values, strict=True):
                if value:
                    part.append(value)
    named = [" · ".join(part) or algorithm(run) for part, run in zip(parts, runs, strict=True)]
    return [
        f"{name} ({run.folder})" if named.count(name) > 1 else name
        for name, run in zip(named, runs, strict=True)
    ]


def _changes(runs: Sequence[Run]) -> list[str]:
    """What each run overrides, without what all of them do alike and what is said anyway.

    Demonstrations are compared with those of runs of the same task.
    """
    shared = set.intersection(*(set(run.overrides.items()) for run in runs))
    said = {"algorithm", "preset"}
    texts = []
    for run in runs:
        changed = [(k, v) for k, v in run.overrides.items() if (k, v) not in shared]
        others = [other.shown for other in runs if other.name == run.name]
        shown = [(k, v) for k, v in run.shown.items() if any(o.get(k) != v for o in others)]
        texts.append(", ".join(f"{k}={v}" for k, v in (*changed, *shown) if k not in said))
    return texts
