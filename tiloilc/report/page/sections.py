"""What a page says of one run: results, automaton, occupancy, trajectories, rewards, film."""

from __future__ import annotations

import base64
from collections.abc import Sequence

from tiloilc.report.markup import Markup, concat, number, tag
from tiloilc.report.page import automata, facts, figures, tables
from tiloilc.report.page.verified import verified
from tiloilc.report.runs.run import Run
from tiloilc.report.states import State, states_of

__all__ = ["automaton", "occupancy", "of_run", "results", "states_in", "warnings"]

Sections = list[tuple[str, Markup]]


def of_run(run: Run) -> Sections:
    """What can be said of a run alone, each part under its head."""
    states = states_in(run)
    found: Sections = []
    if run.verification is not None:
        found.append(("Verification", verified(run.verification)))
    found.append(("Automaton", automaton(run, states)))
    found.append(("Stage occupancy", occupancy(run, states)))
    found.append(("Trajectories", _trajectories(run, states)))
    if run.film:
        found.append(("Film", _film(run.film)))
    if (shown := figures.landscape(run, states)) is not None:
        found.append(("Reward by stage", _landscape(shown)))
    return found


def _film(film: bytes) -> Markup:
    address = f"data:image/gif;base64,{base64.b64encode(film).decode()}"
    said = "An episode of the best policy, with the automaton's state at each step."
    shown = tag("img", src=address, alt=said, class_="film")
    return tag("figure", shown, tag("figcaption", said))


STAGES = (
    "Stage is SIDX(b), the longest way from the start without acceptance; length is N(b), the "
    "longest way through b to acceptance; both in edges."
)

COUNTS = (
    "× says how often an episode arrives in a state and goes along an edge: the mean over one "
    "greedy episode of each seed. Training steps are those of all seeds."
)


def warnings(run: Run, of: str) -> Markup:
    """What a reader has to know before anything else: cut short, files that are missing."""
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


def results(run: Run) -> Markup:
    """The table of results, and what they are compared with."""
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
        when = "is never" if step is None else f"is after {step:,} steps"
        best = facts.optimum_name(run)
        said.append(f"The curve's mean over seeds {when} at 90 % of the {best} ({threshold:.2f}).")
    area = facts.area(run)
    if area is not None:
        said.append(f"Mean height of the learning curve: {area.mean:.2f} ± {area.sd:.2f} visits.")
    if run.final is not None and run.final.optimum is not None:
        name = facts.optimum_name(run).capitalize()
        how = run.final.optimum_how.rstrip(".")
        said.append(f"{name} {number(run.final.optimum)}{f': {how}' if how else ''}.")
    body.append(tag("p", " ".join(said), class_="caption"))
    return concat(body)


def states_in(run: Run) -> tuple[State, ...]:
    """The automaton's states; without a plan as many as the log or the trajectories speak of."""
    count = 0 if run.occupancy is None else run.occupancy.shares.shape[1]
    if run.plan is not None:
        count = len(run.plan.ldba.names)
    elif run.trajectories is not None:
        count = max(count, int(run.trajectories.states.max()) + 1)
    return states_of(run.plan, count)


def occupancy(run: Run, states: Sequence[State]) -> Markup:
    """Where training time went."""
    shown = figures.occupancy(run, states)
    if shown is None:
        return tables.absent("The event log has no stage histogram of this automaton.")
    said = (
        "Share of all seeds' training steps in each automaton state, in the order of the stages: "
        "the higher, the nearer to acceptance."
    )
    return tag("figure", shown, tag("figcaption", said))


def _trajectories(run: Run, states: Sequence[State]) -> Markup:
    shown = figures.paths(run, states)
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


def automaton(run: Run, states: Sequence[State]) -> Markup:
    """The automaton with how often its states and edges are passed, and its stages."""
    if run.plan is None:
        return automata.drawing(run)
    spent = automata.times([run], [facts.algorithm(run)], states)
    return concat(
        automata.drawing(run),
        automata.stages(run.plan.stages, states),
        tag("p", STAGES, class_="caption"),
        "" if spent is None else spent,
        "" if automata.passes(run) is None else tag("p", COUNTS, class_="caption"),
    )
