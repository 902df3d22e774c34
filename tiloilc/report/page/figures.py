"""The figures of a report, from runs: curves, occupancy, trajectories, the automaton."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tiloilc.evaluate import band, generator
from tiloilc.report.charts import Area, Level, Series, area_chart, line_chart
from tiloilc.report.landscape import key, pictures
from tiloilc.report.maps import map_of
from tiloilc.report.markup import Markup, concat, number, tag
from tiloilc.report.page import facts
from tiloilc.report.plane import plane_of
from tiloilc.report.runs.run import Curve, Occupancy, Run
from tiloilc.report.scene import panels, timeline
from tiloilc.report.states import State, legend

__all__ = ["curves", "landscape", "losses", "occupancies", "occupancy", "paths", "small_curves"]

WIDE, NARROW = (960.0, 380.0), (360.0, 280.0)
"""A chart for screens and paper and one for phones; the style sheet shows one of them."""

SMALL = (320.0, 230.0)


def curves(runs: Sequence[Run], names: Sequence[str]) -> Markup | None:
    """Accepting visits over training, of one task's runs; None if no run was evaluated."""
    series = [s for i, (r, n) in enumerate(zip(runs, names, strict=True)) if (s := _of(r, n, i))]
    if not series:
        return None
    about = facts.METRIC_TEXTS[facts.VISITS]
    levels = _levels(runs, names)
    unit = "accepting visits per episode"

    def drawn(width: float, height: float) -> Markup:
        return line_chart(
            series, levels, title=f"{about.title} over training", unit=unit,
            width=width, height=height, labels=width > 500,
        )  # fmt: skip

    keys = [_key("mean", f"{one.label}: mean over seeds", one.style) for one in series]
    if any(len(one.seed_names) > 1 for one in series):
        keys.append(_key("band", "95 % bootstrap interval of the mean", series[0].style))
        keys.append(_key("thin", "single seeds", series[0].style))
    keys += [_key("level", f"{one.label} ({number(one.value)})", one.style) for one in levels]
    return concat(_both(drawn), tag("ul", keys, class_="keys"))


def small_curves(runs: Sequence[Run], names: Sequence[str]) -> Markup | None:
    """The other metrics over training, small; None if there is no curve of any."""
    drawn = []
    for metric in ("eventual_return", "violation_rate", "success"):
        about = facts.METRIC_TEXTS[metric]
        series = [
            s
            for i, (run, name) in enumerate(zip(runs, names, strict=True))
            if (s := _of(run, name, i, metric))
        ]
        if not series:
            continue
        show = (lambda v: f"{v * 100:.0f} %") if about.share else number
        levels = []
        for run in runs:
            cloned = facts.cloned(run, metric)
            if cloned is not None and len(runs) == 1:
                levels.append(Level("cloning alone", "cloning", cloned))
        chart = line_chart(
            series, levels, title=f"{about.title} over training", unit=about.unit,
            width=SMALL[0], height=SMALL[1], show=show,
            top=1.0 if about.share else None, labels=False,
        )  # fmt: skip
        drawn.append(tag("figure", tag("h4", about.title), chart))
    return tag("div", drawn, class_="row") if drawn else None


def losses(run: Run) -> Markup | None:
    """Every loss over training, small; None if none was logged."""
    drawn = []
    for name, values in run.losses.values.items():
        known = Curve(run.losses.steps, {name: values})
        series = _series(run, known, name, name, 0)
        if series is None or np.isinf(values).any():
            continue
        chart = line_chart(
            [series], title=f"{name} over training", unit="loss",
            width=SMALL[0], height=SMALL[1], bottom=None, labels=False,
        )  # fmt: skip
        drawn.append(tag("figure", tag("h4", name), chart))
    return tag("div", drawn, class_="row") if drawn else None


def occupancy(run: Run, states: Sequence[State]) -> Markup | None:
    """Where training time went: the share of each automaton state, stages from the bottom."""
    known = facts.occupancy(run, len(states))
    if known is None:
        return None
    areas, steps = _areas(known, states), known.steps

    def drawn(width: float, height: float) -> Markup:
        title = "Share of training steps in each automaton state"
        return area_chart(steps, areas, title=title, width=width, height=height * 0.8)

    return concat(_both(drawn), legend(tuple(states)))


def occupancies(
    runs: Sequence[Run], names: Sequence[str], states: Sequence[State]
) -> Markup | None:
    """The same of several runs of one automaton, side by side; None if none was logged."""
    drawn = []
    for run, name in zip(runs, names, strict=True):
        known = facts.occupancy(run, len(states))
        if known is None:
            continue
        chart = area_chart(
            known.steps, _areas(known, states),
            title=f"Share of training steps in each automaton state: {name}",
            width=SMALL[0], height=SMALL[1],
        )  # fmt: skip
        drawn.append(tag("figure", tag("h4", name), chart))
    return concat(tag("div", drawn, class_="row"), legend(tuple(states))) if drawn else None


def _areas(occupancy: Occupancy, states: Sequence[State]) -> list[Area]:
    """A layer for each state: stages from the bottom, then acceptance, then the sink."""
    rank = {"live": 0, "accepting": 1, "sink": 2}
    ordered = sorted(states, key=lambda s: (rank[s.kind], s.stage, s.number))
    return [Area(s.label, s.short, s.color, occupancy.shares[:, s.number]) for s in ordered]


def paths(run: Run, states: Sequence[State]) -> Markup | None:
    """One greedy episode a seed: over the map if there is one, and as bars of states."""
    taken = facts.trajectories(run, len(states))
    if taken is None:
        return None
    names = [f"seed {seed}" for seed in run.seeds]
    drawn = None
    if run.plan is not None:
        drawn = map_of(run.plan.environment.id, dict(run.plan.environment.kwargs), run.root)
        width = taken.observations.shape[2]
        seen = taken.observations[taken.states >= 0]
        drawn = drawn or plane_of(run.plan, run.root, seen)
        if drawn is not None and not all(0 <= i < width for i in drawn.position):
            drawn = None

    def bars(width: float, _: float) -> Markup:
        return timeline(taken, states, names, width)

    over_map = None if drawn is None else panels(taken, drawn, states, names)
    missing = tag("p", "The environment publishes no two-dimensional map.", class_="quiet")
    return concat(
        missing if over_map is None else over_map,
        legend(tuple(states)),
        _both(bars),
    )


def landscape(run: Run, states: Sequence[State]) -> Markup | None:
    """The reward over the plane by stage; None where nothing was left to show."""
    if run.plan is None or run.rewards is None or len(run.rewards.mean) != len(states):
        return None
    drawn = map_of(run.plan.environment.id, dict(run.plan.environment.kwargs), run.root)
    if drawn is None or sorted(drawn.position) != [0, 1]:
        return None
    shown = pictures(run.rewards, drawn, states, run.plan)
    return None if shown is None else concat(shown, key())


def _of(run: Run, name: str, place: int, metric: str = facts.VISITS) -> Series | None:
    return _series(run, run.curve, metric, name, place)


def _series(run: Run, curve: Curve, metric: str, name: str, place: int) -> Series | None:
    values = curve.values.get(metric)
    if values is None or not len(values) or np.isnan(values).all():
        return None
    return Series(
        label=name,
        style=f"run-{place % 8}",
        steps=curve.steps,
        band=band(values, generator()),
        seeds=values,
        seed_names=tuple(f"seed {seed}" for seed in run.seeds),
    )


def _levels(runs: Sequence[Run], names: Sequence[str]) -> list[Level]:
    """The optimum once if all runs share it; cloning by run."""
    found: list[Level] = []
    for i, (run, name) in enumerate(zip(runs, names, strict=True)):
        best, cloned = facts.optimum(run), facts.cloned(run, facts.VISITS)
        of = "" if len(runs) == 1 else f", {name}"
        if best is not None and all(one.value != best for one in found if "optimum" in one.style):
            found.append(Level(facts.optimum_name(run), "optimum", best))
        if cloned is not None and all(one.value != cloned for one in found):
            style = f"cloning {'' if len(runs) == 1 else f'run-{i % 8}'}".strip()
            found.append(Level(f"cloning alone{of}", style, cloned))
    return found


def _both(drawn: Callable[[float, float], Markup]) -> Markup:
    return concat(
        tag("div", drawn(*WIDE), class_="for-wide"), tag("div", drawn(*NARROW), class_="for-narrow")
    )


def _key(kind: str, label: str, style: str) -> Markup:
    return tag("li", tag("i", class_=f"key {kind} {style}"), label)
