"""Run folders → one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tiloilc.report.page.document import render
from tiloilc.report.runs.run import Run, read_run
from tiloilc.writing import write_file

__all__ = ["Run", "read_run", "render", "write_report"]


def write_report(runs: Sequence[Path], out: Path) -> Path:
    """Write the report of run folders to `out`, in one step; several runs are compared.

    Raises CompileError RUN701 for a folder that is no run or has a damaged file.
    """
    page = render([read_run(run) for run in runs])
    out.parent.mkdir(parents=True, exist_ok=True)
    write_file(out, page)
    return out
