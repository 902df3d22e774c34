"""Automaton states on the page: their colours, names and legend."""

from __future__ import annotations

from dataclasses import dataclass

from tiloilc.automaton.ldba import StateId
from tiloilc.plan.model import Plan
from tiloilc.report.markup import Markup, tag

__all__ = ["State", "legend", "palette", "states_of", "subscript"]

LIVE = ("#4a7fc1", "#9566b0", "#dd8a1e", "#1f9aa0", "#c05a8d", "#8a8f2f")
"""Colours of states on the way, in their order; told apart by most colour-blind readers."""

ACCEPTING = ("#2e9e57", "#7cc49a", "#12703a")
SINK = "#cf3a35"

LONGEST_NAME = 60


@dataclass(frozen=True)
class State:
    """One automaton state as it is drawn; `kind` is live, accepting or sink."""

    number: StateId
    name: str
    kind: str
    stage: int
    color: str

    @property
    def short(self) -> str:
        """b with the state's number below the line."""
        return f"b{subscript(self.number)}"

    @property
    def label(self) -> str:
        """The number and, in words of the automaton, what is left to do."""
        name = self.name
        if len(name) > LONGEST_NAME:
            name = f"{name[: LONGEST_NAME - 1]}…"
        note = {"accepting": " (accepting)", "sink": " (sink)"}.get(self.kind, "")
        return f"{self.short}{f' · {name}' if name else ''}{note}"


def states_of(plan: Plan | None, count: int) -> tuple[State, ...]:
    """The states in the order of the automaton; without a plan `count` nameless ones."""
    if plan is None or len(plan.ldba.names) != count:
        colors = palette(count)
        return tuple(State(b, "", "live", 0, colors[b]) for b in range(count))
    ldba, stages = plan.ldba, plan.stages
    live = [b for b in ldba.states if b not in ldba.accepting and b != ldba.sink]
    live.sort(key=lambda b: (stages.index[b], b))
    color = dict(zip(live, palette(len(live)), strict=True))
    for i, b in enumerate(sorted(ldba.accepting)):
        color[b] = ACCEPTING[i % len(ACCEPTING)]
    if ldba.sink is not None:
        color[ldba.sink] = SINK
    return tuple(
        State(
            b,
            ldba.names[b],
            "sink" if b == ldba.sink else "accepting" if b in ldba.accepting else "live",
            stages.index[b],
            color[b],
        )
        for b in ldba.states
    )


def palette(count: int) -> list[str]:
    """`count` colours: the first of a fixed list, or that many steps along a ramp through it."""
    if count <= len(LIVE):
        return list(LIVE[:count])
    anchors = [tuple(int(color[i : i + 2], 16) for i in (1, 3, 5)) for color in LIVE]
    ramp = []
    for k in range(count):
        place = k / (count - 1) * (len(anchors) - 1)
        i = min(int(place), len(anchors) - 2)
        mixed = [
            round(a + (b - a) * (place - i))
            for a, b in zip(anchors[i], anchors[i + 1], strict=True)
        ]
        ramp.append("#" + "".join(f"{channel:02x}" for channel in mixed))
    return ramp


def legend(states: tuple[State, ...]) -> Markup:
    """A key of colours in the order of progress: stages, then acceptance, then the sink."""
    rank = {"live": 0, "accepting": 1, "sink": 2}
    ordered = sorted(states, key=lambda s: (rank[s.kind], s.stage, s.number))
    items = [
        tag("li", tag("i", style=f"background:{state.color}"), state.label, title=state.name)
        for state in ordered
    ]
    return tag("ul", items, class_="legend")


def subscript(value: int) -> str:
    """A number in subscript digits."""
    return str(value).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))
