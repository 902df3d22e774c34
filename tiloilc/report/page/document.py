"""One self-contained page from runs: what was asked, what came out, how, and how to do it again."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from importlib.resources import files

from tiloilc.report.markup import Markup, concat, tag
from tiloilc.report.page import facts, several, tables
from tiloilc.report.page.provenance import duration, provenance
from tiloilc.report.page.sections import of_run, results, warnings
from tiloilc.report.runs.run import Run

__all__ = ["render"]


def render(runs: Sequence[Run]) -> str:
    """The whole page, which needs no network: one run is reported, several are compared."""
    assert runs, "a report of no run"
    names = facts.labels(runs)
    single = len(runs) == 1
    title = runs[0].name if single else " / ".join(dict.fromkeys(run.name for run in runs))
    of = [""] if single else [f"{name}: " for name in names]
    body = [_header(runs[0]) if single else several.header(runs, names, title)]
    body += [warnings(run, whose) for run, whose in zip(runs, of, strict=True)]
    if single:
        parts = [("Results", results(runs[0])), ("Learning curves", several.curves(runs, names))]
        parts += of_run(runs[0])
    else:
        parts = [("Comparison", several.comparison(runs, names))]
        parts.append(("Learning curves", several.curves(runs, names)))
        parts += several.shared_sections(runs, names)
    parts.append(("Settings", tables.settings(runs, names)))
    if not single:
        parts.append(("Run by run", several.run_by_run(runs, names)))
    heads = [""] if single else names
    came = concat(provenance(run, name) for run, name in zip(runs, heads, strict=True))
    parts += [("Provenance", came), ("How to read this page", _reading())]
    body += [tag("section", tag("h2", head), content) for head, content in parts]
    return _document(title, concat(body))


def _document(title: str, body: Markup) -> str:
    style, script = _asset("report.css"), _asset("report.js")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
    policy += f"script-src 'sha256-{digest}'"
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=policy),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="color-scheme", content="light dark"),
        tag("meta", name="generator", content="tiloilc"),
        tag("title", f"{title} – tiloilc report"),
        tag("link", rel="icon", href="data:,"),
        tag("style", Markup(style)),
    )
    tip = tag("div", class_="tip", hidden=True)
    page = tag(
        "html", head, tag("body", tag("main", body), tip, tag("script", Markup(script))), lang="en"
    )
    return f"<!DOCTYPE html>\n{page}\n"


def _asset(name: str) -> str:
    """A file of this package: trusted, goes into the page as it is."""
    return files("tiloilc.report.page").joinpath(name).read_text(encoding="utf-8")


def _header(run: Run) -> Markup:
    plan = run.plan
    body = [tag("p", "tiloilc report", class_="eyebrow"), tag("h1", run.name)]
    if plan is not None and plan.description:
        body.append(tag("p", plan.description, class_="lead"))
    if plan is not None and plan.goal:
        body.append(tag("pre", tag("code", plan.goal), class_="formula"))
    body.append(tag("p", facts.algorithm(run), " ", facts.verdict(run), class_="verdict"))
    about = [facts.algorithm(run), f"preset {run.preset}"]
    about.append(f"{len(run.seeds)} seed{'' if len(run.seeds) == 1 else 's'}")
    about.append(f"{run.end:,} environment steps each")
    if run.final is not None and run.final.wall_seconds is not None:
        about.append(f"trained in {duration(run.final.wall_seconds)}")
    body.append(tag("p", " · ".join(about), class_="quiet"))
    return tag("header", body)


def _reading() -> Markup:
    about = {
        one.title: f"{one.about[0].upper()}{one.about[1:]}." for one in facts.METRIC_TEXTS.values()
    }
    about["IQM [95 % CI]"] = (
        "Interquartile mean: the mean over seeds without the lowest and highest quarter, with a "
        "percentile bootstrap interval over seeds."
    )
    about["Optimum, best known"] = (
        "The most accepting visits that an episode can have; where that is not known exactly, the "
        "most that real actions are known to make."
    )
    about["Which policy"] = (
        "Of each seed the best by validation during training, taking its mean action, judged on "
        "fresh episodes. Sampled: the same, drawing actions as in training. At the end: the one "
        "that training ended with. Cloning alone: the one it began with."
    )
    return tables.pairs(about, kind="glossary")
