"""`tiloilc eval`: the saved policies of a run, judged by the protocol."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, say
from tiloilc.cli.jobs import evaluate_job, open_job
from tiloilc.cli.verdict import verdict
from tiloilc.diag import CompileError, Diagnostic


def command(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="A run folder.", exists=True, file_okay=False)
    ],
    episodes: Annotated[
        int | None, typer.Option("--episodes", min=1, help="Episodes per seed.")
    ] = None,
    stochastic: Annotated[
        bool, typer.Option("--stochastic", help="Show sampled instead of greedy actions.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Evaluate the policies of a finished run.

    Prints what they achieve beside the optimum. Greedy and sampled actions are both judged and
    written to eval.json.
    """
    if not (run / "events.jsonl").is_file() and not (run / "checkpoints").is_dir():
        help = "`tiloilc train` prints the run folder that it writes"
        problem = "nothing was trained in this folder"
        path = run.as_posix()
        raise CompileError(Diagnostic.of("RUN701", help=help, path=path, problem=problem))
    with open_job(run) as job:
        evaluation = evaluate_job(job, run, episodes)
    say(f"wrote {(run / 'eval.json').as_posix()}", quiet)
    print(verdict(evaluation, "stochastic" if stochastic else "greedy"))
