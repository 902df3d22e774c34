"""What can be said about training settings before training: of a task file, or changed later."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tiloilc.diag import Diagnostic, Span
from tiloilc.spec.settings import Settings

MAX_BETA = 0.5
"""Below it a later stage always pays more than an earlier one (paper, below Eq. 8)."""


def _nowhere(name: str) -> Span | None:
    return None


def settings_findings(
    settings: Settings, place: Callable[[str], Span | None] = _nowhere
) -> Iterator[Diagnostic]:
    """PLAN404, JOB604 and JOB609; `place` is where a setting is given."""
    if settings.beta >= MAX_BETA:
        beta = f"{settings.beta:g}"
        yield Diagnostic.of("PLAN404", place("beta"), beta=beta, help="1/3 is usual")
    steps, random = settings.steps, settings.learning_starts
    if settings.algorithm != "cloning" and steps <= random:
        yield Diagnostic.of(
            "JOB609",
            place("steps"),
            steps=f"{steps:,}",
            random=f"{random:,}",
            help="raise `steps`, or lower `learning_starts`",
        )
    if settings.algorithm == "cloning" and settings.warm_start == "none":
        problem = "cloning needs a warm start"
        yield _bad("algorithm", problem, "set `warm_start: bc`", place)
    if settings.end_on_sink and not settings.exact_entry:
        problem = "no step of a sink is seen, so its value must be given"
        yield _bad("end_on_sink", problem, "set `exact_entry: true`", place)


def _bad(setting: str, problem: str, help: str, place: Callable[[str], Span | None]) -> Diagnostic:
    return Diagnostic.of("JOB604", place(setting), setting=setting, problem=problem, help=help)
