"""`tiloilc demos convert`: from .npz to Minari and back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, fail, guests, say
from tiloilc.cli.tasks import demonstrations_file, demonstrations_in


def command(
    source: Annotated[
        str, typer.Argument(metavar="A", help="An .npz, or the id of a Minari dataset.")
    ],
    target: Annotated[str, typer.Argument(metavar="B", help="The other of the two.")],
    quiet: Quiet = False,
) -> None:
    """Convert demonstrations: an .npz to a Minari dataset, or a dataset to an .npz.

    Datasets are those on this machine, where MINARI_DATASETS_PATH says, else in ~/.minari. What is
    there already is not overwritten.
    """
    from tiloilc.demos import save
    from tiloilc.demos.minari import to_minari

    if source.endswith(".npz") == target.endswith(".npz"):
        raise fail("one of the two is an .npz, the other the id of a Minari dataset")
    with guests():
        demos = demonstrations_in(source)
        if target.endswith(".npz"):
            path = Path(target)
            if path.exists():
                raise fail(f"`{target}` is there already")
            demonstrations_file(path).parent.mkdir(parents=True, exist_ok=True)
            save(path, demos)
        else:
            to_minari(target, demos)
    say(f"{len(demos)} episodes, {sum(demo.steps for demo in demos.episodes)} steps", quiet)
    print(target)
