"""A run's automaton: drawn with how often its policies pass each state and edge, and as a table."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from tiloilc.plan.model import Stages
from tiloilc.report.markup import Markup, number, tag
from tiloilc.report.page import facts
from tiloilc.report.page.tables import absent, table
from tiloilc.report.runs.reading import Floats
from tiloilc.report.runs.run import Run
from tiloilc.report.states import State

__all__ = ["drawing", "passes", "stages", "times"]


def passes(run: Run) -> Floats | None:
    """[b, c]: how often an episode steps from b to c, the mean over one greedy one of each seed.

    None without trajectories, or with those of another automaton.
    """
    if run.plan is None:
        return None
    count = len(run.plan.ldba.names)
    known = facts.trajectories(run, count)
    if known is None:
        return None
    found = np.zeros((count, count))
    states = known.states
    before, after = states[:, :-1], states[:, 1:]
    taken = (before >= 0) & (after >= 0)
    np.add.at(found, (before[taken], after[taken]), 1.0)
    return found / len(states)


def drawing(run: Run, *, counted: bool = True) -> Markup:
    """The automaton as `viz` draws it; with counts if they are wanted and there are episodes."""
    if run.plan is None:
        return absent("The automaton is not known: plan.json is missing.")
    try:
        from tiloilc.automaton import to_svg

        drawn = to_svg(run.plan.ldba, run.plan.stages, notes=_notes(run) if counted else None)
    except (ImportError, OSError):
        return absent("It cannot be drawn here: Graphviz is missing.")
    return tag("div", inline_svg(drawn, run.plan.name), class_="automaton wide")


def _notes(run: Run) -> dict[str, str]:
    """What stands in the drawing: of states and edges how often they are passed."""
    found = passes(run)
    if run.plan is None or found is None:
        return {}
    ldba = run.plan.ldba
    notes = {f"state {b}": f"×{_often(found[:, b].sum())}" for b in ldba.states if b != ldba.sink}
    seen: set[tuple[int, int]] = set()
    for index, edge in enumerate(ldba.edges):
        pair = (edge.source, edge.target)
        if pair in seen:  # of two edges between the same states nothing is known apart
            continue
        seen.add(pair)
        of = f"edge {index}"
        if edge.source == edge.target:
            of = f"loop {edge.source}"
        elif edge.target == ldba.sink:
            of = f"lost {edge.source}"
        notes[of] = f"×{_often(found[pair])}"
    return notes


def _often(value: float) -> str:
    """A mean count; tenths only of what is small."""
    return number(round(value)) if value >= 10 else number(round(value, 1))


def stages(order: Stages, states: Sequence[State]) -> Markup:
    """The automaton's states with their place in the stage order."""
    rows = []
    for state in states:
        b = state.number
        dead = state.kind == "sink"
        rows.append(
            tag(
                "tr",
                _head(state),
                tag("td", tag("code", state.name) if state.name else ""),
                tag("td", "" if state.kind == "live" else state.kind),
                tag("td", "–" if dead else str(order.index[b]), class_="num"),
                tag("td", "–" if dead else str(order.length[b]), class_="num"),
                tag("td", "–" if dead else str(order.distance[b]), class_="num"),
            )
        )
    heads = ["State", "what is left to do", "", "stage", "length", "to acceptance"]
    return table(heads, rows, "stages")


def times(runs: Sequence[Run], names: Sequence[str], states: Sequence[State]) -> Markup | None:
    """Where runs of one automaton spend their time: training steps, and steps of an episode."""
    rows = []
    for run, name in zip(runs, names, strict=True):
        shares, found = _training(run, len(states)), passes(run)
        if shares is not None:
            rows.append(_times(name, "training steps", [f"{v * 100:.1f} %" for v in shares]))
        if found is not None:
            often = [_often(float(v)) for v in found.sum(axis=0)]
            rows.append(_times(name, "steps of an episode", often))
    heads = [tag("th", _swatch(state), state.short, scope="col") for state in states]
    return table(["", *heads], rows, "stages times") if rows else None


def _times(name: str, what: str, values: Sequence[str]) -> Markup:
    head = tag("th", name, tag("small", what), scope="row")
    return tag("tr", head, [tag("td", value, class_="num") for value in values])


def _training(run: Run, count: int) -> Floats | None:
    """The share of all training steps in each state."""
    known = facts.occupancy(run, count)
    if known is None:
        return None
    mean: Floats = np.average(known.shares, axis=0, weights=np.diff([0, *known.steps]))
    return mean


def _head(state: State) -> Markup:
    return tag("th", _swatch(state), state.short, scope="row")


def _swatch(state: State) -> Markup:
    return tag("i", class_="swatch", style=f"background:{state.color}")


def inline_svg(drawing: str, title: str) -> Markup:
    """An SVG file as an element of a page: no prolog, no ids that others could have too."""
    start = drawing.index("<svg")
    body = drawing[start : drawing.rindex("</svg>") + len("</svg>")]
    if re.search(r"<script|<foreignObject|\son\w+=|javascript:", body, re.IGNORECASE):
        return tag("p", "The drawing was left out: it holds a script.", class_="quiet")
    body = re.sub(r'\sid="[^"]*"', "", body)
    body = re.sub(r'^(<svg\b[^>]*?)\srole="img"', r"\1", body)
    body = re.sub(r"^(<svg\b[^>]*>)\s*<title>.*?</title>", r"\1", body, flags=re.DOTALL)
    label = tag("title", f"Automaton of {title}")
    return Markup(re.sub(r"^<svg\b([^>]*)>", rf'<svg role="img"\1>{label}', body, count=1))
