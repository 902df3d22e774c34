"""How likely policies satisfy the formula, as `tiloilc verify` found it."""

from __future__ import annotations

from tiloilc.report.markup import Markup, concat, tag
from tiloilc.report.page.tables import table
from tiloilc.report.runs.verification import Agent, Verification

__all__ = ["verified"]

MOST_FAILURES = 3
"""Ways to fail that are told; the rest stands in verify.json."""


def verified(found: Verification) -> Markup:
    """What was found of each seed's policy, the most that is possible, and how it fails."""
    how = "How likely the formula is satisfied, without a time limit, computed exactly"
    if not found.exact:
        how = "How likely an episode is as it should be, from episodes played"
        if found.horizon is not None and found.visits is not None:
            visits = f"{found.visits} accepting visit{'' if found.visits == 1 else 's'}"
            how += f": {visits} or more in {found.horizon} steps, and no violation"
    whose = (", of the policy ", tag("code", found.policy)) if found.policy else ()
    body = [tag("p", how, *whose, ".")]
    if found.agents:
        heads = ["Policy", "probability"]
        sampled = any(agent.low is not None for agent in found.agents)
        if sampled:
            level = "" if found.confidence is None else f" [{found.confidence * 100:g} %]"
            heads += [f"between{level}", "episodes"]
        shown_ones = [*found.agents, *([] if found.pooled is None else [found.pooled])]
        rows = [tag("tr", _cells(agent, sampled)) for agent in shown_ones]
        body.append(table(heads, rows, "stages"))
    said = []
    if found.maximum is not None:
        how = f": {found.maximum_how}" if found.maximum_how else ""
        least = "" if found.maximum_exact else "at least "
        said.append(f"The most that a policy can reach is {least}{shown(found.maximum)}{how}.")
    if found.why_not_exact:
        said.append(f"It is not exact: {found.why_not_exact.rstrip('.')}.")
    if said:
        body.append(tag("p", " ".join(said), class_="caption"))
    for failure in found.failures[:MOST_FAILURES]:
        often = (
            "" if failure.probability is None else f" (probability {shown(failure.probability)})"
        )
        head = tag("b", f"How seed {failure.seed} fails{often}: ")
        body.append(tag("p", head, *_prose(failure.reason)))
        if failure.way:
            body.append(
                tag("ol", [tag("li", *_prose(step)) for step in failure.way], class_="quiet")
            )
    return concat(body)


def _prose(text: str) -> list[Markup | str]:
    """What stands between backticks as code."""
    return [tag("code", part) if i % 2 else part for i, part in enumerate(text.split("`"))]


def _cells(agent: Agent, sampled: bool) -> list[Markup]:
    name = "any of them" if agent.seed is None else f"seed {agent.seed}"
    cells = [tag("th", name, scope="row")]
    value = f"{'≥ ' if agent.at_least else ''}{shown(agent.probability)}"
    cells.append(tag("td", value, class_="num strong"))
    if sampled:
        known = agent.low is not None and agent.high is not None
        bounds = f"{shown(agent.low)} and {shown(agent.high)}" if known else "–"
        cells.append(tag("td", bounds, class_="num"))
        cells.append(tag("td", "–" if agent.episodes is None else f"{agent.episodes:,}"))
    return cells


def shown(value: float | None) -> str:
    """A probability with four places; what is close to 0 or 1 is not shown as that."""
    if value is None:
        return "–"
    places = f"{value:.4f}"
    if float(places) in (0.0, 1.0) and value != float(places):
        return f"{value:.3g}" if value < 0.5 else f"1 - {1 - value:.3g}"
    return places.rstrip("0").rstrip(".")
