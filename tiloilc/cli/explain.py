"""`tiloilc explain`: a task or a diagnostic code in words."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import fail
from tiloilc.diag import RULES, did_you_mean
from tiloilc.diag.pages import page, readable


def command(
    subject: Annotated[
        str, typer.Argument(metavar="SPEC|PLAN|HOA|CODE", help="A file, or a code as LTL203.")
    ],
) -> None:
    """Explain a task, an automaton or a diagnostic code in words.

    Of a task: the formula with all its brackets, its class, each stage and what leads on, an
    accepted and a rejected word, and what each discriminator tells apart.
    """
    path = Path(subject)
    if path.suffix.lower() == ".hoa" and path.is_file():
        from tiloilc.cli.subjects import subject_of
        from tiloilc.plan.explain import explain_automaton

        known = subject_of(subject)
        sys.stdout.write(explain_automaton(known.title, known.ldba, known.stages))
    elif path.exists():
        from tiloilc.cli.tasks import plan_of
        from tiloilc.plan.explain import explain

        sys.stdout.write(explain(plan_of(path)))
    elif subject.upper() in RULES:
        sys.stdout.write(readable(page(subject.upper())))
    elif re.fullmatch(r"[A-Za-z]+\d+", subject):
        raise fail(f"unknown code `{subject}`. {did_you_mean(subject.upper(), RULES)}".strip())
    else:
        raise fail(f"there is no file `{subject}`")
