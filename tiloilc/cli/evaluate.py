"""`tiloilc eval`: the saved policies of a run, judged by the protocol."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import Quiet, checked_suffix, fail, guests, say
from tiloilc.cli.jobs import evaluate_job, open_job
from tiloilc.cli.tasks import prepare_drawing
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
    video: Annotated[
        bool, typer.Option("--video", help="Film an episode of the best seed's policy.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="The film, x.gif or x.mp4 [video.gif in the run folder]."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Evaluate the policies of a finished run.

    Prints what they achieve beside the optimum. Greedy and sampled actions are both judged and
    written to eval.json. A film shows the automaton's state at each step; .mp4 needs the extra
    `video`.
    """
    film = out or run / "video.gif"
    if out is not None and not video:
        raise fail("-o names the film that --video makes")
    if video:
        _check_film(run, film)
        prepare_drawing()
    if not (run / "events.jsonl").is_file() and not (run / "checkpoints").is_dir():
        help = "`tiloilc train` prints the run folder that it writes"
        problem = "nothing was trained in this folder"
        path = run.as_posix()
        raise CompileError(Diagnostic.of("RUN701", help=help, path=path, problem=problem))
    with open_job(run) as job:
        evaluation = evaluate_job(job, run, episodes)
    say(f"wrote {(run / 'eval.json').as_posix()}", quiet)
    print(verdict(evaluation, "stochastic" if stochastic else "greedy"))
    if video:
        _film(run, film, quiet)


def _check_film(run: Path, film: Path) -> None:
    """Whether a film can be written at all: before minutes of evaluation."""
    if checked_suffix(film, "a film is", ".gif", ".mp4") == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            help = "pip install 'tiloilc[video]', or write a .gif"
            problem = "the package `imageio-ffmpeg` is not installed"
            about = Diagnostic.of("RUN711", subject=run.as_posix(), problem=problem, help=help)
            raise CompileError(about) from None


def _film(run: Path, path: Path, quiet: bool) -> None:
    """Film the greedy policy of the seed that did best in validation.

    Raises CompileError RUN711 if there is nothing to show.
    """
    from tiloilc.deploy import load_policy
    from tiloilc.deploy.film import film_of
    from tiloilc.report.pictures.film import gif_of, write_mp4
    from tiloilc.writing import write_file

    with guests():
        film, problem = film_of(load_policy(run))
    if problem:
        say(f"the environment gives no frames, its map is drawn: {problem}", quiet)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix.lower() == ".gif":
        write_file(path, gif_of(film))
    else:
        write_mp4(film, path)
    say(f"wrote {path.as_posix()}", quiet)
