"""What the verbs that look at an automaton take: a task file, a plan, a HOA file, a formula."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tiloilc.cli.console import fail, guests
from tiloilc.diag import CompileError

if TYPE_CHECKING:
    from tiloilc.automaton import Ldba
    from tiloilc.demos import DemoSet
    from tiloilc.plan import Plan, Stages

FILES = (".yaml", ".yml", ".json", ".hoa")
"""Suffixes of what is a file even where there is none of that name."""

PATH = re.compile(r"[\w.~-]*(/[\w.~-]*)+")
"""What is one too: names between slashes, which no formula has."""


@dataclass(frozen=True)
class Subject:
    """An automaton with what is known about it. `title` is its formula, or its name.

    `meant` says that the name of a state is the formula of what is left to do.
    """

    title: str
    ldba: Ldba
    stages: Stages | None
    plan: Plan | None = None
    demos: DemoSet | None = None
    meant: bool = True


def subject_of(text: str, propositions: str | None = None) -> Subject:
    """What the argument `text` names: a file or a folder if there is one, else a formula.

    Raises CompileError for a file that cannot be used, Exit for a formula or a missing file.
    """
    path = Path(text)
    if not is_there(text):
        if path.suffix.lower() in FILES or PATH.fullmatch(text):
            raise fail(f"there is no file `{text}`")
        return _of_formula(text, propositions)
    if path.suffix.lower() == ".hoa":
        return _of_hoa(path)
    return _of_task(path)


def is_there(name: str) -> bool:
    """Whether there is a file or folder of this name; of no name, there is none."""
    try:
        return name != "" and Path(name).exists()
    except (OSError, ValueError):  # a formula can be too long for a name, or have a null byte
        return False


def _of_task(path: Path) -> Subject:
    from tiloilc.demos import DemoSet, load
    from tiloilc.driver import compile_spec, plan_file, read_plan

    if path.is_dir() and not plan_file(path).is_file():
        raise fail(f"no plan in `{path.as_posix()}`; compile a task file first")
    if path.is_dir() or path.suffix.lower() == ".json":
        plan, file = read_plan(path), plan_file(path).parent / "demos.npz"
        demos = load(file) if file.is_file() else DemoSet(())
    else:
        with guests():
            result = compile_spec(path)
        plan, demos = result.plan, result.demos
    return Subject(plan.goal, plan.ldba, plan.stages, plan, demos, meant=plan.formula != "")


def _of_hoa(path: Path) -> Subject:
    from tiloilc.automaton import read_hoa

    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise fail(
            f"cannot read `{path.as_posix()}`: not UTF-8 text (byte {error.start})"
        ) from None
    found = read_hoa(text, file=path.as_posix())
    return Subject(found.name or path.stem, found.ldba, stages_of(found.ldba), meant=False)


def _of_formula(text: str, propositions: str | None) -> Subject:
    from tiloilc.automaton import translate
    from tiloilc.cli.logic.formulas import Written, read, show

    written = Written(text)
    try:
        parsed = read(written, propositions)
        ldba = translate(parsed.formula, parsed.propositions)
    except CompileError as error:
        show(error.diagnostics, written)
        raise typer.Exit(1) from None
    return Subject(written.name, ldba, stages_of(ldba))


def stages_of(ldba: Ldba) -> Stages | None:
    """The stages of `ldba`; None where nothing is ever accepted."""
    from tiloilc.plan import stage_plan

    try:
        return stage_plan(ldba)
    except CompileError:
        return None
