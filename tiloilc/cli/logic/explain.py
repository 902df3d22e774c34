"""`tiloilc explain`: a task, an automaton, a formula or a diagnostic code in words."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import fail, guests
from tiloilc.cli.logic.formulas import Propositions
from tiloilc.cli.logic.subjects import is_there, subject_of
from tiloilc.diag import RULES, did_you_mean
from tiloilc.diag.pages import page, readable

if TYPE_CHECKING:
    from tiloilc.plan import Plan


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
    accepted and a rejected word, what each discriminator tells apart, and how often acceptance can
    be visited, where the environment says enough to know.
    """
    path = Path(subject)
    if is_there(subject) and path.suffix.lower() != ".hoa":
        from tiloilc.cli.tasks import plan_of
        from tiloilc.plan.explain import explain

        plan = plan_of(path)
        sys.stdout.write(explain(plan) + _optimum(plan))
    elif subject.upper() in RULES:
        sys.stdout.write(readable(page(subject.upper())))
    elif re.fullmatch(r"[A-Za-z]{3,}\d{3,}", subject):
        raise fail(f"unknown code `{subject}`. {did_you_mean(subject.upper(), RULES)}".strip())
    else:
        from tiloilc.plan.explain import explain_automaton

        known = subject_of(subject, propositions)
        about = explain_automaton(known.title, known.ldba, known.stages, meant=known.meant)
        sys.stdout.write(about)


def _optimum(plan: Plan) -> str:
    """A paragraph on the best that can be done; empty where nothing is known.

    A plan is explained where its environment is not installed, too.
    """
    from tiloilc.driver import labeller
    from tiloilc.evaluate.optimum import task_optimum
    from tiloilc.plan import importable

    task, epsilon = plan.environment, plan.train.epsilon
    try:
        with guests(), importable(Path(plan.root)):
            labels = labeller(plan)
            best = task_optimum(task.id, task.kwargs, labels, plan.ldba, task.horizon, epsilon)
    except Exception:  # an environment is anyone's code
        return ""
    if best is None:
        return ""
    least = "" if best.exact else "at least "
    many = f"{least}{best.accepting_visits:g} accepting visits in {task.horizon} steps"
    return f"\nOptimum\n  {many}: {best.how}\n"
