"""`tiloilc step`: an automaton walked letter by letter, or along a demonstration."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import Quiet, fail, guests, say
from tiloilc.cli.logic.formulas import Propositions, Written
from tiloilc.cli.logic.stepping import Session, Table, read_word
from tiloilc.cli.logic.subjects import Subject, subject_of
from tiloilc.diag import counted

if TYPE_CHECKING:
    from tiloilc.automaton.language.trace import Trace


def command(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="SPEC|PLAN|HOA|FORMULA",
            help="A task file, a build folder or plan, an automaton, or a formula.",
        ),
    ],
    word: Annotated[
        str | None,
        typer.Option(help="Walk along this: `{a} {b}` or `a; b`, with `cycle{c}` at the end."),
    ] = None,
    demo: Annotated[
        int | None,
        typer.Option(min=0, metavar="K", help="Walk along demonstration K of the task, from 0."),
    ] = None,
    propositions: Propositions = None,
    quiet: Quiet = False,
) -> None:
    """Walk an automaton letter by letter, or along a word or a demonstration.

    Prints one line a letter: the time, the letter, the state after it, its stage, whether it
    accepts. Letters are read from the terminal, or from standard input, one a line; there `:back`
    and the like are commands, at a terminal `back` is one too.
    """
    if word is not None and demo is not None:
        raise fail("give --word or --demo, not both")
    known = subject_of(subject, propositions)
    if demo is not None:
        _along_demonstration(known, demo, quiet)
    elif word is not None:
        _along_word(known, word, quiet)
    elif not Session(known, sys.stdin, quiet).run():
        raise typer.Exit(1)


def _along_demonstration(known: Subject, number: int, quiet: bool) -> None:
    from tiloilc.automaton.language.trace import Trace
    from tiloilc.demos import replay
    from tiloilc.driver import labeller
    from tiloilc.plan import importable

    if known.plan is None or not known.demos:
        raise fail("there are no demonstrations: give a task file or a plan that has some")
    if number >= len(known.demos):
        raise fail(
            f"there are demonstrations 0 to {len(known.demos) - 1}, none with number {number}"
        )
    with importable(known.plan.root), guests():
        labels = labeller(known.plan)
        run = replay(known.demos.episodes[number].observations, labels, known.ldba)
    trace = Trace(known.ldba).follow(run.letters.tolist(), run.states.tolist())
    table = Table(known, trace.ldba.propositions, [step.letter for step in trace.steps])
    table.print(trace, counted_from=1)
    lost = "never lost" if run.violates_at is None else f"lost at time {run.violates_at}"
    say(
        f"demonstration {number}: {counted(run.visits, 'accepting visit')} after the start, {lost}",
        quiet,
    )


def _along_word(known: Subject, text: str, quiet: bool) -> None:
    from tiloilc.automaton.language.trace import Trace, accepting_run, unrolled
    from tiloilc.demos import best_run

    written = Written(text, "<word>")
    word = read_word(written, known)
    if word is None:
        raise typer.Exit(1)
    letters, verdict = word.letters, ""
    lasso = word.lasso
    found = None if lasso is None else accepting_run(known.ldba, lasso)
    if lasso is not None and found is not None:
        states, begin = found
        letters = unrolled(lasso, len(states))
        verdict = f"accepted: from time {begin} on this repeats, and accepts again and again"
    else:
        if lasso is not None:
            letters = unrolled(lasso, len(lasso.stem) + 2 * len(lasso.loop))
            verdict = "rejected: no run accepts again and again"
        states = tuple(best_run(letters, known.ldba).tolist())
    trace = Trace(known.ldba).follow(letters, states)
    Table(known, known.ldba.propositions, letters).print(trace)
    say(verdict or _verdict(trace), quiet)


def _verdict(trace: Trace) -> str:
    lost = ", lost for ever" if trace.lost else ""
    return f"{counted(trace.visits, 'accepting visit')}{lost}"
