"""Several runs beside each other: numbers, curves, where training time went, what differs."""

from __future__ import annotations

from collections.abc import Sequence

from tiloilc.report.markup import Markup, concat, tag
from tiloilc.report.page import automata, facts, figures, tables
from tiloilc.report.page.sections import STAGES, of_run, states_in
from tiloilc.report.runs.run import Run

__all__ = ["alike", "comparison", "curves", "header", "run_by_run", "shared_sections"]


def header(runs: Sequence[Run], names: Sequence[str], title: str) -> Markup:
    """The tasks, and a sentence on each run."""
    body = [tag("p", f"tiloilc report · {len(runs)} runs compared", class_="eyebrow")]
    body.append(tag("h1", title))
    goals = dict.fromkeys(run.plan.goal for run in runs if run.plan is not None)
    body += [tag("pre", tag("code", goal), class_="formula") for goal in goals if goal]
    said = [
        tag("li", tag("i", class_=f"key run-{i % 8}"), tag("b", name), " ", facts.verdict(run))
        for i, (run, name) in enumerate(zip(runs, names, strict=True))
    ]
    body.append(tag("ul", said, class_="verdict list"))
    return tag("header", body)


def comparison(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    """The numbers of all runs, and each beside the first of its task."""
    caption = "Greedy policies; mean ± standard deviation over seeds."
    said = (
        "Beside the first run of its task: by how much the mean over seeds is higher, and how "
        "likely a seed of it makes more visits than one of the first (ties count half); both with "
        "bootstrap intervals. Then the step at which the mean over seeds first makes 90 % of the "
        "optimum, or of the best known, in validation, and the area under that curve by its length."
    )
    return concat(
        tables.comparison(runs, names),
        tag("p", caption, class_="caption"),
        tables.beside(runs, names),
        tag("p", said, class_="caption"),
    )


def curves(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    """One figure a task: runs of other tasks have another optimum and another meaning."""
    body = []
    tasks = list(dict.fromkeys(run.name for run in runs))
    for task in tasks:
        mine = [(run, name) for run, name in zip(runs, names, strict=True) if run.name == task]
        some, called = [run for run, _ in mine], [name for _, name in mine]
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


def shared_sections(runs: Sequence[Run], names: Sequence[str]) -> list[tuple[str, Markup]]:
    """For each automaton, which some runs share: its stages, and where the runs' time went."""
    found = []
    groups = alike(runs)
    for group in groups:
        mine, called = [runs[i] for i in group], [names[i] for i in group]
        of = "" if len(groups) == 1 else f" · {', '.join(called)}"
        states = states_in(mine[0])
        plan = mine[0].plan
        body: list[Markup] = []
        if plan is not None:
            body.append(automata.drawing(mine[0], counted=False))
            body += [automata.stages(plan.stages, states), tag("p", STAGES, class_="caption")]
        spent = automata.times(mine, called, states)
        if spent is not None:
            said = (
                "The share of all seeds' training steps in each state, and the steps that an "
                "episode spends there: the mean over one greedy episode of each seed. Below, run "
                "by run, the automaton is drawn with such counts."
            )
            body += [spent, tag("p", said, class_="caption")]
        if body:
            found.append((f"Automaton{of}", concat(body)))
        shown = figures.occupancies(mine, called, states)
        if shown is None:
            shown = tables.absent("The event logs have no stage histogram of this automaton.")
        said = "Share of all seeds' training steps in each automaton state; stages from the bottom."
        body = [shown, tag("p", said, class_="caption")]
        found.append((f"Stage occupancy{of}", concat(body)))
    return found


def alike(runs: Sequence[Run]) -> list[list[int]]:
    """The places of runs in groups of one automaton; a run without a plan is a group of its own."""
    groups: list[list[int]] = []
    for i, run in enumerate(runs):
        for group in groups:
            plan = runs[group[0]].plan
            if plan is not None and run.plan is not None and plan.ldba == run.plan.ldba:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def run_by_run(runs: Sequence[Run], names: Sequence[str]) -> Markup:
    """All that is said of each run alone, folded up."""
    body = []
    for i, (run, name) in enumerate(zip(runs, names, strict=True)):
        key = tag("i", class_=f"key run-{i % 8}")
        parts = [concat(tag("h3", head), content) for head, content in of_run(run)]
        body.append(tag("details", tag("summary", key, " ", name), parts, class_="run"))
    return concat(body)
