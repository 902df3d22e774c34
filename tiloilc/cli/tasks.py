"""What the verbs that take a task file or a plan share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tiloilc.cli.console import fail, guests

if TYPE_CHECKING:
    from tiloilc.plan import Plan


def plan_of(path: Path) -> Plan:
    """The plan of a build folder, of a plan file, or of a task file that is compiled for this.

    Raises CompileError with the errors that prevent it, Exit where there is nothing to read.
    """
    from tiloilc.driver import compile_spec, plan_file, read_plan

    if path.is_dir() and not plan_file(path).is_file():
        raise fail(f"no plan in `{path.as_posix()}`; compile a task file first")
    if path.suffix == ".hoa":
        raise fail("an automaton alone is no task; give a task file or a plan")
    if path.is_dir() or path.suffix == ".json":
        return read_plan(path)
    with guests():
        return compile_spec(path).plan
