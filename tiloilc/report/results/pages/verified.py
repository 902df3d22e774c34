"""`verified.md`: how likely trained policies satisfy their formulas, by `tiloilc verify`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import cast

from tiloilc.diag import counted
from tiloilc.report.results.book import Book
from tiloilc.report.results.markdown import (
    MADE,
    NOT_RUN,
    listed,
    seeds,
    small,
    table,
    whole,
)
from tiloilc.report.results.methods import COMPARED, method_name
from tiloilc.report.results.rows import Fields, Row
from tiloilc.report.results.tasks import title

EXACT = """\
On finite tasks `tiloilc verify` asks the model checker Storm about the Markov chain that the greedy
policy makes of the environment's model: with which probability is the formula satisfied, without
the horizon of training ([ADR 24](../adr/0024-exact-where-a-model-is-published.md))? A cell counts
the agents, each seed's best policy by validation episodes, that satisfy it *for certain*: with
probability 1 exactly. Where they do not all, the mean probability is below.

"""

TRIALS = """
## Elsewhere, by episodes

The share of episodes without violation and with so many accepting visits as are named, over all
agents; below it, how far the Clopper–Pearson bounds of single agents reach. Training never saw
these episodes, and no two agents share one.

"""

WHY = """
## How policies fail

Of agents that do not satisfy the formula for certain: what happens to the one that does worst, by
`tiloilc verify`.

"""


def page(book: Book) -> str:
    """The page; it says so if nothing was verified."""
    text = f"# How likely policies satisfy their formulas\n\n{MADE}\n"
    exact = [task for task in book.tasks if _some(book, task, "exact")]
    played = [task for task in book.tasks if _some(book, task, "simulated")]
    if exact:
        text += EXACT + _cells(book, exact, "exact", _certain) + _walks(book, exact)
    if played:
        text += TRIALS + _cells(book, played, "simulated", _share)
    failing = [line for task in exact + played for line in _failures(book, task)]
    if failing:
        text += WHY + table(("task", "method", "seeds", "what happens"), failing)
    return text if exact or played else f"{text}Nothing was verified yet.\n"


def _some(book: Book, task: str, method: str) -> bool:
    """Whether an agent of the task was verified so."""
    return any(_of(book, task, name, method) for name in COMPARED)


def _of(book: Book, task: str, algorithm: str, method: str) -> Row | None:
    row = book.verification(task, algorithm)
    return row if row is not None and row.runs[0]["method"] == method else None


def _cells(book: Book, tasks: list[str], method: str, said: Callable[[Row], str]) -> str:
    """A row a task, a column a method; first the most that any policy could reach."""
    rows = []
    for task in tasks:
        found = [_of(book, task, name, method) for name in COMPARED]
        most = next((_most(row) for row in found if row is not None), "–")
        cells = [
            NOT_RUN if row is None else f"[{whole(said(row))}](all.md#{row.anchor}){_below(row)}"
            for row in found
        ]
        rows.append([title(task), most, *cells])
    return table(("task", "any policy at most", *map(method_name, COMPARED)), rows)


def _most(row: Row) -> str:
    best = row.runs[0]["maximum"]
    if not isinstance(best, Mapping):
        return "–"
    return f"{'' if best['exact'] else '≥ '}{_number(Fraction(best['fraction']))}"


def _number(value: Fraction) -> str:
    return str(value) if value.denominator == 1 else f"{float(value):.4f}"


def _certain(row: Row) -> str:
    return f"{sum(map(_is_certain, row.runs))} of {len(row.runs)}"


def _is_certain(run: Fields) -> bool:
    return _agent(run).get("fraction") == "1"


def _agent(run: Fields) -> Mapping[str, object]:
    return cast("Mapping[str, object]", run["verified"])


def _share(row: Row) -> str:
    return f"{row.values('verified', 'fine').sum() / row.values('verified', 'episodes').sum():.4f}"


def _below(row: Row) -> str:
    """The mean probability of agents that are not all certain; what trials were."""
    if row.runs[0]["method"] == "exact":
        sure = all(map(_is_certain, row.runs))
        return "" if sure else small(f"mean {row.values('verified', 'probability').mean():.3f}")
    trials = cast("Mapping[str, object]", row.runs[0]["trials"])
    low, high = row.values("verified", "low"), row.values("verified", "high")
    return small(
        f"agents {low.min():.3f} to {high.max():.3f}",
        f"≥ {trials['visits']} in {trials['horizon']} steps",
    )


def _walks(book: Book, tasks: list[str]) -> str:
    """Whether walks in the environments agree with what is exact."""
    runs = [
        (task, name, run)
        for task in tasks
        for name in COMPARED
        if (row := _of(book, task, name, "exact")) is not None
        for run in row.runs
        if run["walked"] is not None
    ]
    if not runs:
        return ""
    kinds = sorted(
        {tuple(sorted(cast("Mapping[str, float]", r["walked"]).items())) for *_, r in runs}
    )
    walks = listed([_walk(dict(kind)) for kind in kinds])
    missed = [(task, name, run["seed"]) for task, name, run in runs if not _agent(run)["agrees"]]
    held = f"{len(runs) - len(missed)} of {counted(len(runs), 'agent')}"
    text = (
        f"\nBeside that each agent walked in the environment itself: {walks}.\n"
        "A walk is fine without violation and with an accepting visit in its second half. The\n"
        f"bounds of the share of fine walks hold the exact probability for {held}.\n"
    )
    if missed:
        told = [f"{title(task)} {method_name(name)} seed {seed}" for task, name, seed in missed]
        text += f"They do not for {listed(told)}.\n"
    return text


def _walk(about: Mapping[str, float]) -> str:
    return (
        f"{about['episodes']:,} walks of {about['steps']:,} steps, with bounds of"
        f" {about['confidence']:.6g} confidence"
    )


def _failures(book: Book, task: str) -> Iterator[list[str]]:
    """A line a method with agents that fail, and in which way the worst one does."""
    for name in COMPARED:
        row = book.verification(task, name)
        failing = [] if row is None else [run for run in row.runs if _fails(run)]
        if failing:
            told = [run for run in failing if run["reason"]] or failing
            worst = min(told, key=lambda run: cast("float", _agent(run)["probability"]))
            said = f"seed {worst['seed']}: {worst['reason']}" if worst["reason"] else "–"
            numbers = seeds([cast("int", run["seed"]) for run in failing])
            yield [title(task), method_name(name), numbers, said]


def _fails(run: Fields) -> bool:
    agent = _agent(run)
    exact = run["method"] == "exact"
    return not _is_certain(run) if exact else agent["fine"] != agent["episodes"]
