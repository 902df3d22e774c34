"""`tiloilc verify`: how likely a policy satisfies its formula."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import Quiet, checked_suffix, fail, guests, say
from tiloilc.cli.jobs import EVENTS, open_job
from tiloilc.cli.logic.subjects import subject_of
from tiloilc.cli.run import Record
from tiloilc.cli.tasks import task_file
from tiloilc.cli.verified import lines

if TYPE_CHECKING:
    from tiloilc.evaluate.verify import Verification, Wanted

PICTURE = "counterexample.svg"


class Method(StrEnum):
    """How probabilities are found."""

    AUTO = "auto"
    EXACT = "exact"
    SIMULATE = "simulate"


class Saved(StrEnum):
    """The policies of a run that can be verified."""

    BEST = "best"
    LAST = "last"
    CLONING = "cloning"


class Format(StrEnum):
    """What is printed."""

    TEXT = "text"
    JSON = "json"


def command(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="RUN|SPEC", help="A run folder; or a task file, a build folder, a bundled task."
        ),
    ],
    policy: Annotated[
        Saved | None, typer.Option("--policy", help="Which policy of the run.  [default: best]")
    ] = None,
    seed: Annotated[
        int | None, typer.Option("--seed", help="One agent alone; else all of the run.")
    ] = None,
    method: Annotated[
        Method | None,
        typer.Option("--method", help="auto: exact where the task has a finite model."),
    ] = None,
    episodes: Annotated[
        int | None, typer.Option("--episodes", min=1, help="Trials of each agent.")
    ] = None,
    confidence: Annotated[
        float, typer.Option("--confidence", min=0.5, max=0.999999999, help="That of the bounds.")
    ] = 0.95,
    precision: Annotated[
        float | None,
        typer.Option(
            "--precision",
            min=0.001,
            max=0.5,
            help="Half the width of the bounds: plays, or tells, as many episodes as it needs.",
        ),
    ] = None,
    visits: Annotated[
        int, typer.Option("--visits", min=1, help="Accepting visits that a trial must make.")
    ] = 1,
    time_limit: Annotated[
        float,
        typer.Option(
            "--time-limit", min=0.1, max=1_000_000, help="Seconds for each of Storm's answers."
        ),
    ] = 600.0,
    walk: Annotated[
        int | None,
        typer.Option(
            "--walk",
            metavar="STEPS",
            min=2,
            help="Have each agent walk so far, too: does that agree with what is exact?",
        ),
    ] = None,
    at_least: Annotated[
        float | None,
        typer.Option("--at-least", min=0.0, max=1.0, help="Exit with 1 unless this is shown."),
    ] = None,
    format: Annotated[Format, typer.Option("--format", help="Of what is printed.")] = Format.TEXT,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", help="The counterexample, x.svg or x.png.  [default: in the run folder]"
        ),
    ] = None,
    record: Record = None,
    quiet: Quiet = False,
) -> None:
    """Say how likely the policies of a run satisfy the formula.

    On finite tasks the exact probability without a time limit, by Storm (the extra `verify`), and
    the most that any policy could reach. Elsewhere bounds from episodes: no violation, and enough
    accepting visits within the horizon. Prints how a policy fails, and draws it where the task has
    a map. Writes verify.json into the run folder. Of a task alone: the most that could be reached,
    and where that is not exact, what its expert achieves.
    """
    given = {
        "--policy": policy, "--seed": seed, "--method": method, "--walk": walk, "-o": out,
        "--record": record,
    }  # fmt: skip
    if out is not None:
        checked_suffix(out, "a counterexample is drawn as", ".svg", ".png")
    if walk is not None and method is Method.SIMULATE:
        raise fail("--walk goes beside what is exact, and --method simulate leaves that out")
    from tiloilc.deploy import usual_policy
    from tiloilc.evaluate.verify import Wanted

    run = Path(subject)
    wanted = Wanted(
        policy=usual_policy(run) if policy is None else policy.value,
        method=(method or Method.AUTO).value,
        seed=seed,
        episodes=episodes,
        confidence=confidence,
        half_width=precision,
        visits=visits,
        time_limit=time_limit,
        steps=walk,
    )
    if run.is_dir() and ((run / EVENTS).is_file() or (run / "checkpoints").is_dir()):
        found = _verified_run(run, wanted, out, record, quiet)
    else:
        if about_runs := [name for name, value in given.items() if value is not None]:
            raise fail(f"{about_runs[0]} is about a run, and `{subject}` is none")
        found = _verified_task(subject, wanted, quiet)
    if format is Format.JSON:
        print(json.dumps(found.to_json(), indent=1))
    else:
        print("\n".join(lines(found)))
    if at_least is not None and not _reaches(found, at_least, quiet):
        raise typer.Exit(1)


def _verified_run(
    run: Path, wanted: Wanted, out: Path | None, record: Path | None, quiet: bool
) -> Verification:
    """The policies of a run; writes `verify.json`, the picture and records."""
    from tiloilc.evaluate import append, prepare, records_of_run
    from tiloilc.evaluate.verify import VERIFY, records_of, verify_run
    from tiloilc.report.pictures import png_of, svg_of
    from tiloilc.report.pictures.counterexample import counterexample_picture
    from tiloilc.writing import write_file

    if record is not None:  # what is in the way is found out now
        records_of_run(run)
        prepare(record)
    with open_job(run) as job:
        found = verify_run(
            job.plan, job.demos, job.labels, run, wanted, lambda text: say(text, quiet)
        )
        drawn = None
        if found.counterexamples:
            drawn = counterexample_picture(job.plan, found.policy, found.counterexamples[0])
    write_file(run / VERIFY, json.dumps(found.to_json(), indent=1) + "\n")
    say(f"wrote {(run / VERIFY).as_posix()}", quiet)
    if record is not None:
        append(record, records_of(found, run))
    picture = out or run / PICTURE
    if drawn is not None:
        picture.parent.mkdir(parents=True, exist_ok=True)
        write_file(picture, png_of(drawn) if picture.suffix.lower() == ".png" else svg_of(drawn))
        say(f"wrote {picture.as_posix()}", quiet)
    elif out is None:
        picture.unlink(missing_ok=True)  # of an earlier verification
    else:
        why = "the task has no map" if found.counterexamples else "there is no counterexample"
        say(f"nothing drawn in `{out.as_posix()}`: {why}", quiet)
    return found


def _verified_task(subject: str, wanted: Wanted, quiet: bool) -> Verification:
    """What is known of a task without a run."""
    from tiloilc.driver import labeller
    from tiloilc.evaluate.verify import verify_task
    from tiloilc.plan import importable

    path = task_file(subject)
    if not path.exists():
        raise fail(f"there is no `{subject}`")
    known = subject_of(str(path))
    if known.plan is None:
        raise fail("an automaton alone is no task; give a task file or a plan")
    expert = known.demos.meta.get("expert") if known.demos is not None else None
    with importable(known.plan.root), guests():
        return verify_task(
            known.plan,
            labeller(known.plan),
            expert if isinstance(expert, str) else None,
            wanted,
            lambda text: say(text, quiet),
        )


def _reaches(found: Verification, wanted: float, quiet: bool) -> bool:
    """Whether it is shown that at least `wanted` is reached: by each agent, or by some policy."""
    if not found.judged:
        reached = found.possible(wanted)
        say(f"a policy reaches {wanted:g}: {'yes' if reached else 'not shown'}", quiet)
        return reached
    missing = found.missing(wanted)
    shown = f"not shown of seed{'s' if missing[1:] else ''} {', '.join(map(str, missing))}"
    say(f"at least {wanted:g}: {shown if missing else 'yes'}", quiet)
    return not missing
