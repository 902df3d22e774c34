"""`all.md`: every row there is, where its records are, and rows that differ in one setting."""

from __future__ import annotations

from tiloilc.evaluate import generator, summarise
from tiloilc.report.results.book import Book
from tiloilc.report.results.markdown import MADE, between, optimum, seeds, spread, table
from tiloilc.report.results.measures import gap
from tiloilc.report.results.rows import FRESH, Row

HEAD = f"""\
# All rows

{MADE}
One row for each task, method, settings and length. *Visits* are accepting visits an episode with
greedy actions, of each seed's best policy by validation episodes ([ADR
9](../adr/0009-policies-chosen-on-validation-episodes.md)); mean ± standard deviation over seeds,
then the interquartile mean with its 95 % bootstrap interval. *At the end* is the last policy,
*cloning* the one before reinforcement learning began. *Violations* are episodes that enter a sink.
Learning reads the states of demonstrations only, unless a row says otherwise. An optimum with ≥ is
a lower bound, reached by real actions.

*Settings* are a method, a preset, and what differs from that preset; on other pages a method's row
is the one with the settings that the task file has now, the longest of several. For another method
than the task file's they are without those that make the two what they are (`optimistic` is for
TiLoIL and not for baselines). Runs that were cut short do not count. Of one seed that was run at
several commits the latest counts (records without a time count as the oldest). Seeds from {FRESH}
on served no choice of settings; where a row has any, only they count.

The records of a row, one a line, are printed by
`python -m tiloilc.report.results row ANCHOR`, where the anchor is the end of the link to the row.
A row is made again by `tiloilc run specs/TASK.yaml --set NAME=VALUE … --steps STEPS --seeds COUNT
--set first_seed=FIRST --record results/TASK.jsonl.gz`, with its settings, steps and seeds.

"""

PAIRS = """
## One thing changed

Rows above and those that set one thing more, and by how much the mean of their visits differs, with
its 95 % bootstrap interval: what keeps clear of 0 is more than chance among seeds.

"""

COLUMNS = (
    "task", "settings", "seeds", "steps", "visits", "IQM [95 %]", "violations", "at the end",
    "cloning", "optimum", "records",
)  # fmt: skip

PAIR_COLUMNS = (
    "task", "settings", "steps", "changed", "visits before", "visits after", "difference [95 %]",
)  # fmt: skip


def page(book: Book) -> str:
    """The page; the same records give the same text."""
    text = HEAD + table(COLUMNS, [_row(row, book) for row in book.rows])
    pairs = [pair for row in book.rows for pair in _pairs(row, book)]
    return text + (PAIRS + table(PAIR_COLUMNS, pairs) if pairs else "")


def _row(row: Row, book: Book) -> list[str]:
    visits = row.values("greedy")
    summary = summarise(visits, generator())
    assert summary is not None, f"{row.anchor} has no visits"
    file = f"[{seeds(row.seeds)}](../../results/{row.task}.jsonl.gz)"
    return [
        f'<a id="{row.anchor}"></a>`{row.task}`',
        _settings(row),
        str(len(row.runs)),
        f"{row.steps:,}",
        spread(visits),
        f"{summary.iqm:.2f} {between(summary.iqm_interval)}",
        f"{row.values('greedy', 'violation_rate').mean():.1%}",
        spread(row.values("last")),
        spread(row.values("cloning")),
        optimum(book.optimum(row.task)),
        f"seeds {file} at {', '.join(row.commits)}",
    ]


def _settings(row: Row) -> str:
    return f"{row.algorithm} {row.preset} {row.named}".strip()


def _pairs(row: Row, book: Book) -> list[list[str]]:
    """The row beside each that has one change more than it."""
    found = []
    for other in book.of_task(row.task, row.algorithm):
        same = (row.preset, row.demonstrations, row.steps)
        more = set(other.changes) - set(row.changes)
        if (other.preset, other.demonstrations, other.steps) != same or len(more) != 1:
            continue
        ((name, value),) = more
        if other.without(name) != row.changes:
            continue
        found.append(
            [
                f"`{row.task}`",
                _settings(row),
                f"{row.steps:,}",
                f"{name}={value}",
                spread(row.values("greedy")),
                spread(other.values("greedy")),
                gap(row, other),
            ]
        )
    return found
