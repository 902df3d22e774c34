"""`tiloilc explain`: a task, an automaton, a formula or a diagnostic code in words."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Annotated

import typer

from tiloilc.cli.console import fail
from tiloilc.cli.logic.formulas import Propositions
from tiloilc.cli.logic.subjects import is_there, subject_of
from tiloilc.diag import RULES, did_you_mean
from tiloilc.diag.pages import page, readable


def command(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="SPEC|PLAN|HOA|FORMULA|CODE", help="A file, a formula, or a code as LTL203."
        ),
    ],
    propositions: Propositions = None,
) -> None:
    """Explain a task, an automaton, a formula or a diagnostic code in words.

    Of a task: the formula with all its brackets, its class, each stage and what leads on, an
    accepted and a rejected word, and what each discriminator tells apart.
    """
    path = Path(subject)
    if is_there(path) and path.suffix.lower() != ".hoa":
        from tiloilc.cli.tasks import plan_of
        from tiloilc.plan.explain import explain

        sys.stdout.write(explain(plan_of(path)))
    elif subject.upper() in RULES:
        sys.stdout.write(readable(page(subject.upper())))
    elif re.fullmatch(r"[A-Za-z]{3,}\d{3,}", subject):
        raise fail(f"unknown code `{subject}`. {did_you_mean(subject.upper(), RULES)}".strip())
    else:
        from tiloilc.plan.explain import explain_automaton

        known = subject_of(subject, propositions)
        about = explain_automaton(known.title, known.ldba, known.stages, meant=known.meant)
        sys.stdout.write(about)
