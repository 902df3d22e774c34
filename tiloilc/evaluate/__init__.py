"""The protocol by which policies are judged, the statistics over seeds, and the records of runs."""

from tiloilc.evaluate.metrics import METRICS, EpisodeMetrics, eventual_return, measure
from tiloilc.evaluate.records import (
    Record,
    append,
    dedupe,
    prepare,
    read,
    records_of_run,
    split_seeds,
)
from tiloilc.evaluate.statistics import (
    Band,
    Interval,
    Summary,
    area_under_curve,
    band,
    difference,
    generator,
    interquartile_mean,
    probability_of_improvement,
    steps_to_threshold,
    stratified_bootstrap,
    summarise,
)

__all__ = [
    "METRICS",
    "Band",
    "EpisodeMetrics",
    "Interval",
    "Record",
    "Summary",
    "append",
    "area_under_curve",
    "band",
    "dedupe",
    "difference",
    "eventual_return",
    "generator",
    "interquartile_mean",
    "measure",
    "prepare",
    "probability_of_improvement",
    "read",
    "records_of_run",
    "split_seeds",
    "steps_to_threshold",
    "stratified_bootstrap",
    "summarise",
]
