"""Statistics over seeds: what is printed beside every result (measuring: evaluation protocol).

Mean ± standard deviation is what the paper prints; the interquartile mean (IQM) with stratified
bootstrap intervals is what Agarwal et al. (2021, "Deep reinforcement learning at the edge of the
statistical precipice") recommend for few seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = [
    "RESAMPLES",
    "Band",
    "Interval",
    "Summary",
    "area_under_curve",
    "band",
    "difference",
    "generator",
    "interquartile_mean",
    "mean",
    "probability_of_improvement",
    "steps_to_threshold",
    "stratified_bootstrap",
    "summarise",
]

Floats: TypeAlias = npt.NDArray[np.float64]
Statistic: TypeAlias = Callable[[Floats], Floats]
"""Reduces the last axis (seeds): [..., n] → [...]."""

RESAMPLES = 10_000
"""Bootstrap resamples; the end points of an interval then move by a hundredth of it, where few
seeds lie far apart by some."""


@dataclass(frozen=True, slots=True)
class Interval:
    """A confidence interval, both ends included."""

    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Summary:
    """One metric over `count` seeds. `sd` has n − 1 below the line and is 0 for a single seed."""

    count: int
    mean: float
    sd: float
    iqm: float
    mean_interval: Interval
    iqm_interval: Interval


@dataclass(frozen=True, slots=True)
class Band:
    """A curve with its interval, each an array [points]; nan at points without a value."""

    mean: Floats
    low: Floats
    high: Floats


def generator(seed: int = 0) -> np.random.Generator:
    """The generator of the intervals of a report: the same run gives the same page."""
    return np.random.default_rng(seed)


def mean(values: Floats) -> Floats:
    """The mean over the last axis."""
    result: Floats = values.mean(axis=-1)
    return result


def interquartile_mean(values: Floats) -> Floats:
    """The mean over the last axis without its lowest and highest quarter (rounded down)."""
    from scipy.stats import trim_mean

    return np.asarray(trim_mean(values, 0.25, axis=-1), dtype=np.float64)


def summarise(
    values: Sequence[float | None] | Floats,
    rng: np.random.Generator,
    *,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
) -> Summary | None:
    """Mean, spread and intervals of one metric over seeds; None if no seed has a value.

    Seeds whose value is undefined (None or nan) are left out; `count` says how many remain.
    """
    present = _defined(values)
    if present.size == 0:
        return None
    return Summary(
        count=int(present.size),
        mean=float(present.mean()),
        sd=float(present.std(ddof=1)) if present.size > 1 else 0.0,
        iqm=float(interquartile_mean(present)),
        mean_interval=stratified_bootstrap(
            [present], mean, rng, confidence=confidence, resamples=resamples
        ),
        iqm_interval=stratified_bootstrap(
            [present], interquartile_mean, rng, confidence=confidence, resamples=resamples
        ),
    )


def stratified_bootstrap(
    strata: Sequence[Floats],
    statistic: Statistic,
    rng: np.random.Generator,
    *,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
) -> Interval:
    """Percentile interval of `statistic` over all values, resampled within each stratum.

    A stratum [n_i] holds the seeds of one task; tasks keep their share in every resample, so that
    an aggregate over tasks is not widened by tasks that happen to be drawn twice. One stratum is
    the ordinary bootstrap.
    """
    assert strata, "no strata"
    assert all(values.ndim == 1 and values.size for values in strata), "strata are lists of seeds"
    drawn = [v[rng.integers(v.size, size=(resamples, v.size))] for v in strata]
    estimates = statistic(np.concatenate(drawn, axis=1))
    tail = (1.0 - confidence) / 2.0
    low, high = np.quantile(estimates, [tail, 1.0 - tail])
    return Interval(float(low), float(high))


def difference(before: Floats, after: Floats, rng: np.random.Generator) -> tuple[float, Interval]:
    """How much higher the mean of `after` [n] is than that of `before` [m]; 95 % interval."""
    n = len(before)

    def gap(drawn: Floats) -> Floats:
        return np.asarray(drawn[..., n:].mean(-1) - drawn[..., :n].mean(-1))

    interval = stratified_bootstrap([before, after], gap, rng)
    return float(after.mean() - before.mean()), interval


def probability_of_improvement(
    pairs: Sequence[tuple[Floats, Floats]],
    rng: np.random.Generator,
    *,
    confidence: float = 0.95,
    resamples: int = 2_000,
) -> tuple[float, Interval]:
    """How likely a run of X is better than one of Y on a task of several, each as often drawn.

    `pairs` are (x [n], y [m]), one a task; ties count half (Agarwal et al. 2021). The interval is a
    stratified bootstrap: seeds of both are drawn anew within each task.
    """
    assert pairs, "no tasks"
    found, drawn = 0.0, np.zeros(resamples)
    for x, y in pairs:
        better = _above(x[None, :], y[None, :])
        found += float(better[0]) / len(pairs)
        one, other = (v[rng.integers(v.size, size=(resamples, v.size))] for v in (x, y))
        drawn += _above(one, other) / len(pairs)
    tail = (1.0 - confidence) / 2.0
    low, high = np.quantile(drawn, [tail, 1.0 - tail])
    return found, Interval(float(low), float(high))


def _above(x: Floats, y: Floats) -> Floats:
    """For each row of x [k, n] and y [k, m] the share of pairs in which x is greater."""
    gap = x[:, :, None] - y[:, None, :]
    share: Floats = ((gap > 0) + 0.5 * (gap == 0)).mean(axis=(1, 2))
    return share


def band(
    values: Floats,
    rng: np.random.Generator,
    *,
    statistic: Statistic = mean,
    confidence: float = 0.95,
    resamples: int = 2_000,
) -> Band:
    """The curve of `statistic` over seeds and its pointwise bootstrap interval.

    `values` is [points, seeds]; a resample draws seeds once and takes their whole curves. Seeds
    without a value at a point (nan) are left out there.
    """
    assert values.ndim == 2, f"[points, seeds], not {values.shape}"
    points, seeds = values.shape
    assert seeds > 0, "no seeds"
    centre, low, high = (np.full(points, np.nan) for _ in range(3))
    picks = rng.random((resamples, seeds))  # where in the list of seeds, as a share of its length
    tail = (1.0 - confidence) / 2.0
    for i, row in enumerate(values):
        present = row[~np.isnan(row)]
        if present.size == 0:
            continue
        drawn = present[(picks[:, : present.size] * present.size).astype(np.int64)]
        centre[i] = statistic(present)
        low[i], high[i] = np.quantile(statistic(drawn), [tail, 1.0 - tail])
    return Band(centre, low, high)


def steps_to_threshold(steps: Sequence[int], values: Floats, threshold: float) -> int | None:
    """Sample efficiency: the first evaluated step at which the mean over seeds is ≥ `threshold`.

    `values` is [points, seeds], `steps` ascending environment steps of one seed. None if never.
    Nothing is interpolated: between two evaluations nothing is known.
    """
    assert values.shape[0] == len(steps), "one row a step"
    reached = np.flatnonzero(values.mean(axis=1) >= threshold)
    return int(steps[reached[0]]) if reached.size else None


def area_under_curve(steps: Sequence[int], values: Floats) -> Floats:
    """Each seed's mean height [seeds] over training: trapezoids over the range of steps.

    `values` is [points, seeds]. In the unit of the metric, so that runs of other lengths compare;
    a single point is its own height.
    """
    assert values.shape[0] == len(steps) > 0, "one row a step"
    if len(steps) == 1:
        return np.asarray(values[0], dtype=np.float64)
    at = np.asarray(steps, dtype=np.float64)
    assert (np.diff(at) > 0).all(), "steps ascend"
    heights = (values[1:] + values[:-1]) / 2.0
    area: Floats = (heights * np.diff(at)[:, None]).sum(axis=0) / (at[-1] - at[0])
    return area


def _defined(values: Sequence[float | None] | Floats) -> Floats:
    """The values that are neither None nor nan, as an array."""
    column = np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    return column[~np.isnan(column)]
