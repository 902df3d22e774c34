"""One self-contained page from runs: what was asked, what came out, how, and how to do it again."""

from __future__ import annotations

import base64
import hashlib
import shlex
from collections.abc import Sequence
from importlib.resources import files

from tiloilc.report.markup import Markup, concat, number, tag
from tiloilc.report.page import facts, figures, tables
from tiloilc.report.runs.run import Run
from tiloilc.report.states import State, states_of

__all__ = ["render"]


def render(runs: Sequence[Run]) -> str:
    """The whole page, which needs no network: one run is reported, several are compared."""
    assert runs, "a report of no run"
    names = facts.labels(runs)
    single = len(runs) == 1
    title = runs[0].name if single else " / ".join(dict.fromkeys(run.name for run in runs))
    body = [_header(runs[0])] if single else [_comparison_header(runs, title)]
    body += [_warnings(run, "" if single else f"{n}: ") for run, n in zip(runs, names, strict=True)]
    sections: list[tuple[str, Markup]] = []
    if single:
        sections.append(("Results", _results(runs[0])))
    else:
        sections.append(("Comparison", _comparison(runs, names)))
    sections.append(("Learning curves", _curves(runs, names)))
    drawn = [_automaton_of(run, runs) for run in runs]
    for run, name, shared in zip(runs, names, drawn, strict=True):
        of = "" if single else f" · {name}"
        states = _states(run)
        if shared is not None:
            sections.append((f"Automaton{'' if shared else of}", _automaton(run, states)))
        sections.append((f"Stage occupancy{of}", _occupancy(run, states)))
        sections.append((f"Trajectories{of}", _trajectories(run, states)))
        if (shown := figures.landscape(run, states)) is not None:
            sections.append((f"Reward by stage{of}", _landscape(shown)))
    sections.append(("Settings", tables.settings(runs, names)))
    sections.append(
        (
            "Provenance",
            concat(_provenance(r, "" if single else n) for r, n in zip(runs, names, strict=True)),
        )
    )
    sections.append(("How to read this page", _reading()))
    body += [tag("section", tag("h2", head), content) for head, content in sections]
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
        about.append(f"trained in {_duration(run.final.wall_seconds)}")
    body.append(tag("p", " · ".join(about), class_="quiet"))
    return tag("header", body)


def _comparison_header(runs: Sequence[Run], title: str) -> Markup:
    body = [tag("p", f"tiloilc report · {len(runs)} runs compared", class_="eyebrow")]
    body.append(tag("h1", title))
    goals = dict.fromkeys(run.plan.goal for run in runs if run.plan is not None)
    body += [tag("pre", tag("code", goal), class_="formula") for goal in goals if goal]
    names = facts.labels(runs)
    said = [
        tag("li", tag("i", class_=f"key run-{i % 8}"), tag("b", name), " ", facts.verdict(run))
        for i, (run, name) in enumerate(zip(runs, names, strict=True))
    ]
    body.append(tag("ul", said, class_="verdict list"))
    return tag("header", body)


def _warnings(run: Run, of: str) -> Markup:
    said = []
    if run.interrupted:
        total = run.total
        goal = "" if total is None else f" of {total:,}"
        said.append(
            f"{of}This run was cut short at step {run.end:,}{goal}: "
            "its numbers say where it stood then, not what it would have reached."
        )
    said += [f"{of}{note}" for note in run.notes]
    return concat(tag("p", line, class_="warning", role="note") for line in said)


def _results(run: Run) -> Markup:
    if not facts.greedy(run):
        return tables.absent("There is no evaluation to show.")
    body = [tables.results(run)]
    said = []
    if run.final is not None and run.final.episodes is not None:
        said.append(
            f"{run.final.episodes} episodes a seed, begun from random seeds kept for evaluation."
        )
    elif run.final is None:
        said.append("From the last evaluation during training; eval.json is missing.")
    reached = facts.efficiency(run)
    if reached is not None:
        threshold, step = reached
        when = "is not reached" if step is None else f"is reached after {step:,} steps"
        said.append(f"90 % of the optimum ({threshold:.2f} visits, mean over seeds) {when}.")
    area = facts.area(run)
    if area is not None:
        said.append(f"Mean height of the learning curve: {area.mean:.2f} ± {area.sd:.2f} visits.")
    if run.final is not None and run.final.optimum is not None:
        kind = "exact" if run.final.optimum_exact else "a bound"
        how = run.final.optimum_how.rstrip(".") or kind
        said.append(f"Optimum of {number(run.final.optimum)}: {how}.")
    body.append(tag("p", " ".join(said), class_="caption"))
    return concat(body)


def _comparison(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    caption = "Greedy policies; mean ± standard deviation over seeds."
    return concat(tables.comparison(runs, names), tag("p", caption, class_="caption"))


def _curves(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    """One figure a task: runs of other tasks have another optimum and another meaning."""
    body = []
    tasks = list(dict.fromkeys(run.name for run in runs))
    for task in tasks:
        mine = [(run, name) for run, name in zip(runs, names, strict=True) if run.name == task]
        some, called = [run for run, _ in mine], [name for _, name in mine]
        if len(runs) == 1:
            called = [facts.algorithm(runs[0])]
        if len(tasks) > 1:
            body.append(tag("h3", task))
        main = figures.curves(some, called)
        small = figures.small_curves(some, called)
        if main is None:
            body.append(tables.absent("There was no evaluation during training."))
            continue
        said = "Greedy policies on validation episodes, during training."
        body.append(tag("figure", main, tag("figcaption", said)))
        if small is not None:
            body.append(small)
    if len(runs) == 1 and (lost := figures.losses(runs[0])) is not None:
        body.append(tag("details", tag("summary", "Training losses"), lost))
    return concat(body)


def _states(run: Run) -> tuple[State, ...]:
    count = 0 if run.occupancy is None else run.occupancy.shares.shape[1]
    if run.plan is not None:
        count = len(run.plan.ldba.names)
    elif run.trajectories is not None:
        count = max(count, int(run.trajectories.states.max()) + 1)
    return states_of(run.plan, count)


def _occupancy(run: Run, states: Sequence[State]) -> Markup:
    shown = None if _misfit(run, states) else figures.occupancy(run, states)
    if shown is None:
        return tables.absent("The event log has no stage histogram of this automaton.")
    said = (
        "Share of all seeds' training steps in each automaton state, in the order of the stages: "
        "the higher, the nearer to acceptance."
    )
    return tag("figure", shown, tag("figcaption", said))


def _trajectories(run: Run, states: Sequence[State]) -> Markup:
    shown = None if _misfit(run, states) else figures.paths(run, states)
    if shown is None:
        return tables.absent("There is no trajectories.npz of this automaton in the run folder.")
    said = (
        "One greedy episode a seed. The colour is the automaton state in which each step is "
        "taken; ○ start, filled discs accepting visits, × the sink."
    )
    return concat(shown, tag("p", said, class_="caption"))


def _landscape(shown: Markup) -> Markup:
    said = (
        "The reward of Eq. 8 at every place, by the discriminators that training ended with; mean "
        "over seeds. Each stage has its own range, about SIDX / N in white: the colour is what its "
        "discriminator makes of a place."
    )
    return concat(shown, tag("p", said, class_="caption"))


def _automaton(run: Run, states: Sequence[State]) -> Markup:
    if run.plan is None:
        return tables.absent("The automaton is not known: plan.json is missing.")
    drawn = figures.automaton(run)
    said = (
        "Stage is SIDX(b), the longest way from the start without acceptance; length is N(b), the "
        "longest way through b to acceptance; both in edges."
    )
    return concat(
        tables.absent("It cannot be drawn here: Graphviz is missing.") if drawn is None else drawn,
        tables.stages(run.plan.stages, states),
        tag("p", said, class_="caption"),
    )


def _misfit(run: Run, states: Sequence[State]) -> bool:
    """Whether the log or the trajectories speak of states that the plan does not have."""
    if run.occupancy is not None and run.occupancy.shares.shape[1] != len(states):
        return True
    return run.trajectories is not None and int(run.trajectories.states.max()) >= len(states)


def _provenance(run: Run, name: str) -> Markup:
    final = run.final
    digests = {"plan": run.plan_digest} if run.plan_digest else {}
    versions = dict(run.versions)
    if run.plan is not None:
        digests |= run.plan.digests
        versions = {"tiloilc": run.plan.version, **versions}
    body = [tag("h3", name)] if name else []
    body.append(tables.pairs(versions, kind="tight"))
    if final is not None and final.machine:
        body.append(tables.pairs(final.machine, kind="tight"))
    if final is not None and final.git_commit:
        digests = {"git commit": final.git_commit, **digests}
    body.append(tables.pairs(digests, kind="digests"))
    body.append(tag("h4", "To do it again"))
    body.append(tag("pre", tag("code", "\n".join(_commands(run))), class_="commands"))
    return concat(body)


def _commands(run: Run) -> list[str]:
    lines = []
    if run.final is not None and run.final.git_commit:
        commit = run.final.git_commit.removesuffix("-dirty")
        note = "" if commit == run.final.git_commit else "  # and what was not committed then"
        lines.append(f"git checkout {shlex.quote(commit)}{note}")
    changed = "".join(f" --set {shlex.quote(f'{k}={v}')}" for k, v in run.overrides.items())
    digests = {} if run.plan is None else run.plan.digests
    spec = next((key[5:] for key in digests if key.startswith("spec:")), f"{run.name}.yaml")
    lines.append(f"tiloilc compile {shlex.quote(spec)}")
    lines.append(f"tiloilc train {shlex.quote(f'build/{run.name}')}{changed}")
    lines.append(f"tiloilc eval {shlex.quote(f'runs/{run.name}/{run.folder}')}")
    lines.append(f"tiloilc report {shlex.quote(f'runs/{run.name}/{run.folder}')}")
    return lines


def _reading() -> Markup:
    about = {
        one.title: f"{one.about[0].upper()}{one.about[1:]}." for one in facts.METRIC_TEXTS.values()
    }
    about["IQM [95 % CI]"] = (
        "Interquartile mean: the mean over seeds without the lowest and highest quarter, with a "
        "percentile bootstrap interval over seeds."
    )
    about["Which policy"] = (
        "Of each seed the best by validation during training, taking its mean action, judged on "
        "fresh episodes. Sampled: the same, drawing actions as in training. At the end: the one "
        "that training ended with. Cloning alone: the one it began with."
    )
    return tables.pairs(about, kind="glossary")


def _automaton_of(run: Run, runs: Sequence[Run]) -> bool | None:
    """Whether the run's automaton is that of all runs; None if an earlier run has shown it."""
    same = [r for r in runs if r.plan is not None and run.plan and r.plan.ldba == run.plan.ldba]
    if same and same[0] is not run:
        return None
    return len(same) == len(runs)


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h {minutes % 60} min"
