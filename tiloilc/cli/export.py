"""`tiloilc export`: a trained policy for other programs."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, fail, guests, say


def command(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="A run folder.", exists=True, file_okay=False)
    ],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The folder; else RUN/export.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option("--seed", help="Which agent; else the best by validation.")
    ] = None,
    policy: Annotated[
        str | None,
        typer.Option("--policy", help="Which policy: best (or last, if none), last or cloning."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write one agent's policy as an ONNX model, with its automaton.

    Prints the folder. policy.json in it says how model and automaton go together; example programs
    are in examples/exported_policy.
    """
    from tiloilc.deploy import export, load_policy

    if find_spec("onnx") is None:
        raise fail("this needs the package onnx: pip install 'tiloilc[onnx]'")
    folder = out or run / "export"
    with guests():
        chosen = load_policy(run, seed=seed, policy=policy)
        export(chosen, folder)
    said = "the policy" if policy is None else f"the policy `{policy}`"
    say(f"exported {said} of seed {chosen.seed}", quiet)
    print(folder.as_posix())
