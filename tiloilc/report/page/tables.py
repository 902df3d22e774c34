"""The tables of a report: results over seeds, comparison of runs, stages, settings, provenance."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np

from tiloilc.evaluate import Summary
from tiloilc.report.charts import strip
from tiloilc.report.frame import short
from tiloilc.report.markup import Markup, concat, number, tag
from tiloilc.report.page import facts
from tiloilc.report.runs.reading import Floats
from tiloilc.report.runs.run import Run

__all__ = ["absent", "beside", "comparison", "differences", "pairs", "results", "settings", "table"]


def results(run: Run) -> Markup:
    """One row a metric: mean ± sd, IQM with interval and dots; then what it is compared with."""
    values = facts.greedy(run)
    policies = {} if run.final is None else run.final.policies
    beside = {
        "sampled": policies.get("stochastic", {}),
        "at the end": policies.get("last", {}),
        "cloning alone": facts.cloning(run),
    }
    beside = {head: metrics for head, metrics in beside.items() if metrics}
    heads = ["Greedy policy", "mean ± sd", "IQM [95 % CI]", "every seed"]
    heads += list(beside)
    best = facts.optimum(run)
    rows = []
    for name, about in facts.METRIC_TEXTS.items():
        column = values.get(name)
        over = facts.summary(column)
        if column is None or over is None:
            continue
        unit = about.unit
        if name == "eventual_return" and run.final is not None and run.final.gamma is not None:
            unit = f"γ = {number(run.final.gamma)}"
        if name == "first_visit" and over.count < len(run.seeds):
            unit += f", {over.count} of {len(run.seeds)} seeds"
        of_best = _of_best(over, run) if name == facts.VISITS else ""
        cells = [
            tag("th", about.title, tag("small", unit), scope="row", title=about.about),
            tag("td", plus_minus(over, about), of_best, class_="num strong"),
            tag("td", iqm(over, about), class_="num"),
            tag("td", dots(run, name, column, over, best), class_="dots"),
        ]
        for metrics in beside.values():
            cells.append(tag("td", _brief(metrics.get(name), about), class_="num"))
        rows.append(tag("tr", cells))
    return table(heads, rows, "results")


def comparison(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    """One row a run; runs of one task share the scale of their dots."""
    heads = ["Run", "seeds × steps", "accepting visits", "IQM [95 % CI]", "every seed"]
    heads += ["eventual return", "violations"]
    visits = facts.METRIC_TEXTS[facts.VISITS]
    rows = []
    for i, (run, name) in enumerate(zip(runs, names, strict=True)):
        key = tag("i", class_=f"key run-{i % 8}")
        cells = [tag("th", key, name, scope="row")]
        note = tag("small", "cut short") if run.interrupted else ""
        cells.append(tag("td", f"{len(run.seeds)} × {short(run.end)}", note, class_="num"))
        values = facts.greedy(run)
        column = values.get(facts.VISITS)
        over = facts.summary(column)
        best = facts.optimum(run)
        if column is None or over is None:
            cells.append(tag("td", "not evaluated", colspan="3"))
        else:
            peers = [facts.greedy(r).get(facts.VISITS) for r in runs if r.name == run.name]
            highest = max(float(np.nanmax(p)) for p in peers if p is not None and len(p))
            cells += [
                tag("td", plus_minus(over, visits), _of_best(over, run), class_="num strong"),
                tag("td", iqm(over, visits), class_="num"),
                tag(
                    "td",
                    dots(run, facts.VISITS, column, over, max(best or 0.0, highest)),
                    class_="dots",
                ),
            ]
        for metric in ("eventual_return", "violation_rate"):
            shown = _brief(values.get(metric), facts.METRIC_TEXTS[metric])
            cells.append(tag("td", shown, class_="num"))
        rows.append(tag("tr", cells))
    return table(heads, rows, "results comparison")


def beside(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    """Each run beside the first of its task: how much better, how surely; how fast it learns."""
    heads = ["Run", "visits more [95 % CI]", "P(better) [95 % CI]", "90 % of the optimum"]
    heads += ["mean height of the curve"]
    rows = []
    for i, (run, name) in enumerate(zip(runs, names, strict=True)):
        cells = [tag("th", tag("i", class_=f"key run-{i % 8}"), name, scope="row")]
        first = next(r for r in runs if r.name == run.name)
        gap = None if first is run else facts.better(run, first)
        if gap is None:
            shown = "the first of its task" if first is run else "not evaluated"
            cells.append(tag("td", shown, colspan="2", class_="quiet"))
        else:
            more, likely = gap
            cells += [tag("td", more, class_="num"), tag("td", likely, class_="num")]
        reached = facts.efficiency(run)
        step = None if reached is None else reached[1]
        told = "–" if reached is None else "not reached" if step is None else f"after {short(step)}"
        area = facts.area(run)
        height = "–" if area is None else plus_minus(area, facts.METRIC_TEXTS[facts.VISITS])
        cells += [tag("td", told, class_="num"), tag("td", height, class_="num")]
        rows.append(tag("tr", cells))
    return table(heads, rows, "comparison beside")


def settings(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    """The task and all settings of the first run whose plan is known; what differs between runs."""
    body: list[Markup] = []
    if len(runs) > 1:
        changed = differences(runs, names)
        body.append(absent("All runs have the same settings.") if changed is None else changed)
    known = [run for run in runs if run.plan is not None]
    if not known:
        return concat(body, absent("Settings are not known: plan.json is missing."))
    plan = known[0].plan
    assert plan is not None
    rows = [
        tag(
            "tr",
            tag("th", tag("code", p.name), scope="row"),
            tag("td", tag("code", p.text or p.python)),
        )
        for p in plan.predicates
    ]
    task = {
        "environment": plan.environment.id,
        **{name: str(value) for name, value in plan.environment.kwargs.items()},
        "horizon": f"{plan.environment.horizon} steps",
        "observed": ", ".join(f"{n} [{a}:{b}]" for n, (a, b) in plan.fields.items()) or "–",
        "demonstrations": _demonstrations(plan.demonstrations.model_dump()),
        "evaluation": f"{plan.evaluate.episodes} episodes a seed",
    }
    head = "Task" if len(runs) == 1 else f"All of {names[runs.index(known[0])]}"
    body += [
        tag("h3", head),
        pairs(task, kind="task"),
        tag("div", tag("table", tag("tbody", rows), class_="predicates"), class_="wide"),
        tag("h3", "Training"),
        pairs(settings_of(known[0]), tuple(known[0].overrides)),
    ]
    return concat(body)


def _demonstrations(given: dict[str, object]) -> str:
    source = given.get("source") or given.get("file") or given.get("minari") or ""
    if not source:
        return "none"
    said = f"{given.get('count')} from {source}"
    if given.get("max_visits"):
        said += f", each cut after {given['max_visits']} visits"
    if given.get("max_steps"):
        said += f", each cut after {given['max_steps']} steps"
    return f"{said}, actions {given.get('actions')}"


def settings_of(run: Run) -> dict[str, str]:
    """Every setting of training as text, overrides applied, in the order of the settings."""
    if run.plan is None:
        return dict(run.overrides)
    given: dict[str, object] = run.plan.train.model_dump(mode="json")
    shown = {name: _setting(value) for name, value in given.items()}
    return shown | {name: _setting(_value(text)) for name, text in run.overrides.items()}


def _value(text: str) -> object:
    """What an override's text stands for: JSON, or the text itself."""
    try:
        value: object = json.loads(text)
    except json.JSONDecodeError:
        return text
    return value


def differences(runs: Sequence[Run], names: Sequence[str]) -> Markup | None:
    """The settings in which runs differ, one column a run; None if there are none."""
    given = [
        settings_of(run) | {name: _setting(value) for name, value in run.shown.items()}
        for run in runs
    ]
    keys = list(dict.fromkeys(key for one in given for key in one))
    rows = []
    for key in keys:
        values = [one.get(key, "–") for one in given]
        if len(set(values)) > 1:
            cells = [tag("td", tag("code", value)) for value in values]
            rows.append(tag("tr", tag("th", tag("code", key), scope="row"), cells))
    return table(["Setting", *names], rows, "differences") if rows else None


def pairs(values: Mapping[str, str], marked: Sequence[str] = (), *, kind: str = "") -> Markup:
    """Names and values side by side, in as many columns as fit; `marked` ones stand out."""
    items = [
        tag(
            "div",
            tag("dt", name),
            tag("dd", value, tag("small", "overridden") if name in marked else ""),
            class_="marked" if name in marked else None,
        )
        for name, value in values.items()
    ]
    return tag("dl", items, class_=f"pairs {kind}".strip())


def plus_minus(over: Summary, about: facts.MetricText) -> str:
    """Mean ± standard deviation, the unit once."""
    if over.count == 1:
        return about.show(over.mean)
    if about.share:
        return f"{facts.percent(over.mean)} ± {facts.percent(over.sd)} %"
    return f"{over.mean:.2f} ± {over.sd:.2f}"


def iqm(over: Summary, about: facts.MetricText) -> str:
    """Interquartile mean and its interval, the unit once."""
    low, high = over.iqm_interval.low, over.iqm_interval.high
    if about.share:
        return f"{facts.percent(over.iqm)} [{facts.percent(low)}, {facts.percent(high)}] %"
    return f"{over.iqm:.2f} [{low:.2f}, {high:.2f}]"


def dots(run: Run, metric: str, column: Floats, over: Summary, best: float | None) -> Markup:
    """The seeds on a line from 0 to 1, to the optimum, or to the greatest value."""
    about = facts.METRIC_TEXTS[metric]
    high = 1.0 if about.share else float(np.nanmax(column))
    if metric == facts.VISITS and best is not None:
        high = max(high, best)
    names = [f"seed {seed}" for seed in run.seeds]
    return strip(column, names, over, 0.0, high, about.show)


def _brief(values: Floats | None, about: facts.MetricText) -> str:
    over = facts.summary(values)
    return "–" if over is None else plus_minus(over, about)


def _of_best(over: Summary, run: Run) -> str:
    best = facts.optimum(run)
    if best is None or best <= 0:
        return ""
    return tag("small", f"{over.mean / best * 100:.0f} % of the {facts.optimum_name(run)}")


def _setting(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, list):
        return " × ".join(_setting(item) for item in value)
    return str(value)


def table(heads: Sequence[str], rows: Sequence[Markup], kind: str) -> Markup:
    """A table that scrolls sideways where there is no room; a head of Markup is a whole cell."""
    cells = [n if isinstance(n, Markup) else tag("th", n, scope="col") for n in heads]
    head = tag("tr", cells)
    body = tag("table", tag("thead", head), tag("tbody", rows), class_=kind)
    return tag("div", body, class_="wide")


def absent(said: str) -> Markup:
    """In place of what there is nothing of: why."""
    return tag("p", said, class_="quiet absent")
