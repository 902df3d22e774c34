"""`tiloilc demos check`: demonstrations run through a task's automaton, as a table of stages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import Quiet, fail, guests, report, say
from tiloilc.cli.tasks import demonstrations_in, task_file
from tiloilc.diag import CompileError, Severity

if TYPE_CHECKING:
    from tiloilc.automaton import Ldba
    from tiloilc.demos import Replay
    from tiloilc.plan import Stages


def command(
    spec: Annotated[
        str, typer.Argument(metavar="SPEC", help="A task file, or the name of a bundled one.")
    ],
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[FILE]", help="An .npz or the id of a Minari dataset; else the task's own."
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Run demonstrations through the task's automaton.

    Prints a line a demonstration: its steps, its accepting visits, the step at which it violates
    the formula, and when it first came to each stage. Findings go to standard error; exit with 1
    if one is an error.
    """
    from tiloilc.demos import replay_all
    from tiloilc.driver import analyse
    from tiloilc.plan import importable

    path = task_file(spec)
    given = None if source is None else demonstrations_in(source)
    with guests():
        task = analyse(path, given)
    if task.demos is None or task.failed:
        if not task.diagnostics:
            raise fail(f"`{path.as_posix()}` asks for no demonstrations; name a file of them")
        raise CompileError(*task.diagnostics)
    assert task.labels is not None
    assert task.ldba is not None
    assert task.stages is not None
    with importable(path.parent), guests():
        _, replays = replay_all(task.demos, task.labels, task.ldba)
    for line in table(replays, task.ldba, task.stages):
        print(line)
    about = [d for d in task.diagnostics if d.code.startswith("DEMO")]
    if not quiet or any(d.severity is Severity.ERROR for d in about):
        report(about)
    say(summary(replays), quiet)


def table(replays: Sequence[Replay], ldba: Ldba, stages: Stages) -> Iterator[str]:
    """The lines of the table, its head first."""
    live = [b for b in ldba.states if b != ldba.sink]
    indices = sorted({stages.index[b] for b in live})
    of = {i: [b for b in live if stages.index[b] == i] for i in indices}
    heads = [f"{i}{'*' if set(of[i]) & ldba.accepting else ''}" for i in indices]
    yield f"{'':28}stage, first reached at step"
    yield f"{'demo':>4}{'steps':>7}{'visits':>8}{'lost':>7}  {_row(heads)}"
    for number, run in enumerate(replays):
        path = run.states.tolist()
        first = {b: path.index(b) for b in live if b in path}
        cells = [str(min((first[b] for b in of[i] if b in first), default="-")) for i in indices]
        lost = "-" if run.violates_at is None else str(run.violates_at)
        yield f"{number:>4}{len(path) - 1:>7}{run.visits:>8}{lost:>7}  {_row(cells)}"


def summary(replays: Sequence[Replay]) -> str:
    """How many do what is asked."""
    fine = sum(run.visits > 0 and run.violates_at is None for run in replays)
    lost = sum(run.violates_at is not None for run in replays)
    return f"{fine} of {len(replays)} reach acceptance without violation, {lost} violate"


def _row(cells: Sequence[str]) -> str:
    return "".join(f"{cell:>6}" for cell in cells).rstrip()
