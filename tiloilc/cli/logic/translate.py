"""`tiloilc translate`: LTL to automata on standard output."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from tiloilc.cli.console import fail
from tiloilc.cli.logic.formulas import Propositions, Written, read, show
from tiloilc.diag import CompileError

if TYPE_CHECKING:
    from tiloilc.automaton.ldba import Ldba
    from tiloilc.ltl import Parsed

COLUMNS = ("formula", "states", "edges", "accepting", "deterministic", "jumps", "ms")


class Format(StrEnum):
    """What is written."""

    HOA = "hoa"
    DOT = "dot"
    JSON = "json"
    CSV = "csv"


Acceptance = Literal["state", "edge"]
Construction = Literal["auto", "asymmetric", "symmetric"]
Order = Literal["written", "free"]
"""The choices of `tiloilc.automaton.translate`, which is not imported to show the help."""


@dataclass(frozen=True)
class _Job:
    """What is asked of each formula. The limits are the translator's own where None."""

    acceptance: Acceptance
    construction: Construction
    order: Order
    names: str | None
    max_states: int | None
    timeout: float | None

    def translate(self, parsed: Parsed) -> Ldba:
        from tiloilc.automaton import translate
        from tiloilc.automaton.limits import MAX_STATES, TIMEOUT

        return translate(
            parsed.formula,
            parsed.propositions,
            acceptance=self.acceptance,
            construction=self.construction,
            order=self.order,
            max_states=self.max_states or MAX_STATES,
            timeout=self.timeout or TIMEOUT,
        )


def command(
    formula: Annotated[str | None, typer.Argument(metavar="FORMULA", help="In LTL.")] = None,
    file: Annotated[
        Path | None,
        typer.Option(help="Formulas, one a line, instead of one.", exists=True, dir_okay=False),
    ] = None,
    format: Annotated[Format, typer.Option(help="csv: a table of sizes.")] = Format.HOA,
    acceptance: Annotated[Acceptance, typer.Option(help="On states or edges.")] = "state",
    construction: Annotated[
        Construction, typer.Option(help="What ε-jumps guess; auto: the smaller automaton.")
    ] = "auto",
    order: Annotated[
        Order, typer.Option(help="free: steps of a cycle need not be taken as they are written.")
    ] = "written",
    complete: Annotated[
        bool, typer.Option(help="With the sink, so that every letter has an edge (hoa).")
    ] = False,
    propositions: Propositions = None,
    max_states: Annotated[int | None, typer.Option(min=1, help="Give up beyond these.")] = None,
    timeout: Annotated[
        float | None, typer.Option(min=0.001, help="Give up after so many seconds.")
    ] = None,
) -> None:
    """Translate LTL to limit-deterministic Büchi automata.

    The columns of csv are formula, states, edges, accepting, deterministic, jumps and ms; the sink
    and its edges are not counted, and a formula that is too large has empty columns.
    """
    if (formula is None) == (file is None):
        raise fail("give a formula, or --file FORMULAS")
    job = _Job(acceptance, construction, order, propositions, max_states, timeout)
    texts = [Written(formula)] if formula is not None else []
    if file is not None:
        texts = _formulas(file)
    if format is Format.CSV:
        failed = _table(texts, job)
    else:
        done = [_one(text, format, complete, job) for text in texts]
        failed = not all(done)
    if failed:
        raise typer.Exit(1)


def _formulas(file: Path) -> list[Written]:
    """The formulas of a file."""
    try:
        lines = file.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise fail(
            f"cannot read `{file.as_posix()}`: not UTF-8 text (byte {error.start})"
        ) from None
    texts = [Written(line, file.as_posix(), n) for n, line in enumerate(lines, 1)]
    return [text for text in texts if text.name and not text.name.startswith("#")]


def _one(text: Written, format: Format, complete: bool, job: _Job) -> bool:
    from tiloilc.automaton import to_dot, to_hoa
    from tiloilc.plan import automaton_json
    from tiloilc.plan.canonical import canonical

    try:
        ldba = job.translate(read(text, job.names))
    except CompileError as error:
        show(error.diagnostics, text)
        return False
    if format is Format.HOA:
        sys.stdout.write(to_hoa(ldba, name=text.name, complete=complete, acceptance=job.acceptance))
    elif format is Format.DOT:
        sys.stdout.write(to_dot(ldba, title=text.name))
    else:
        sys.stdout.write(canonical({"formula": text.name, **automaton_json(ldba)}) + "\n")
    return True


def _table(texts: list[Written], job: _Job) -> bool:
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(COLUMNS)
    failed = False
    for text in texts:
        try:
            parsed = read(text, job.names)
            begun = perf_counter()
            ldba = job.translate(parsed)
            ms = (perf_counter() - begun) * 1000
            writer.writerow([text.name, *_sizes(ldba), f"{ms:.2f}"])
        except CompileError as error:
            show(error.diagnostics, text)
            failed = True
            writer.writerow([text.name, *[""] * (len(COLUMNS) - 1)])
        sys.stdout.flush()
    return failed


def _sizes(ldba: Ldba) -> Iterator[object]:
    """The columns between the formula and the milliseconds."""
    live = [e for e in ldba.edges if ldba.sink not in (e.source, e.target)]
    yield len(ldba.names) - (ldba.sink is not None)
    yield len(live)
    yield len(ldba.accepting) or len(ldba.accepting_edges)
    yield str(not ldba.jumps).lower()
    yield len(ldba.jumps)
