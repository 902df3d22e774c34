"""The table of goals as a page of Markdown, with where the time of an update goes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tiloilc.bench.markdown import machine, table
from tiloilc.bench.measurement import Measurement, Spread
from tiloilc.bench.turns import Share

HEAD = """\
# Benchmarks

Written by `make bench`, not by hand. Medians with quartiles in brackets. Whoever is compared ran
side by side, in a process of its own, on one pinned core with one thread, turn and turn about; the
ratio is taken between turns that follow each other. Their seconds are those of processor time,
which on a core of one's own are the clock's; those of commands and tasks are the clock's. A goal is
the least ratio where there is something to compare with, else the most that the value may be.

Measured on {machine}, with {versions}.
"""

UPDATES = """\
An update is a batch of 64 from the replay and one step of critics, actor, temperature and targets;
ours includes the rewards of automaton states and, with K = 4, a step of each discriminator.
Networks are those of the paper's table 5 (actor 3 × 256, critics 2 × 256), for 31 observations,
five automaton states as one-hot and 4 actions; others see as many numbers. Stable-Baselines3 and
SBX are called for many updates at once, when they are fastest. CleanRL's loop is written out from
its published description. The matrix products are those of one update, one after the other, by the
fastest of torch's library, numpy's and the operator that compiled updates have; nothing is added or
drawn.
"""


PROFILES = """\
## Where the time of an update goes

Our own updates by PyTorch's profiler: time in each operation without those that it calls, to which
the profiler adds its own. `tiloilc::product` (`bmm` where it cannot be built) are the matrix
products; what begins with `graph` are loops that the compiler made of everything between them, the
optimiser's steps among it.
"""


def benchmarks_page(
    parts: Mapping[str, Sequence[Measurement]],
    profiles: Mapping[str, Sequence[Share]],
    versions: Mapping[str, str],
) -> str:
    """The page of all measurements, by part; `profiles` say whose update each is of."""
    told = ", ".join(f"{name} {number}" for name, number in versions.items())
    rows = [row for part in parts.values() for row in part]
    lines = [_line(row) for row in rows]
    columns = ("what", "unit", "measured", "against", "theirs", "ratio", "goal", "reached")
    page = [HEAD.format(machine=machine(), versions=told), table(columns, lines), UPDATES]
    missed = sum(row.missed for row in rows)
    page.append(f"{missed} of {sum(row.goal is not None for row in rows)} goals are missed.\n")
    if profiles:
        page.append(PROFILES)
        page += [_profile(title, shares) for title, shares in profiles.items()]
    return "\n".join(page)


def _line(row: Measurement) -> list[str]:
    sign = "" if row.goal is None else "≥ " if row.against else "≤ "
    times = "×" if row.against else f" {row.unit}"
    reached = "–"
    if row.goal is not None and (row.against is None or row.ratio is not None):
        reached = "**missed**" if row.missed else "yes"
    return [
        row.name,
        row.unit,
        "never" if row.value is None and row.against is None else _spread(row.value),
        row.against or "–",
        _spread(row.theirs),
        _spread(row.ratio, "×"),
        "–" if row.goal is None else f"{sign}{row.goal:g}{times}",
        reached,
    ]


def _spread(spread: Spread | None, unit: str = "") -> str:
    if spread is None:
        return "–"
    if spread.low == spread.high:
        return f"{_number(spread.median)}{unit}"
    return f"{_number(spread.median)}{unit} ({_number(spread.low)}–{_number(spread.high)})"


def _number(value: float) -> str:
    """Three digits, more before the point if need be."""
    if value == 0 or value == int(value) or abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}"


def _profile(title: str, profile: Sequence[Share]) -> str:
    total = sum(share.ms for share in profile)
    lines = [
        [f"`{share.operation}`", f"{share.calls:.3g}", f"{share.ms:.3f}", f"{share.ms / total:.0%}"]
        for share in profile
    ]
    head = f"### {title}: {total:.2f} ms\n\n"
    return head + table(("operation", "calls", "ms", "share"), lines)
