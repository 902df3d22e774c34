"""The commands of every day do not wait for libraries that they do not need."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest


def imported(*arguments: str, cwd: Path) -> set[str]:
    """The modules that `python -m tiloilc ARGUMENTS` imports, by Python's own account."""
    result = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "tiloilc", *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    told = [line for line in result.stderr.splitlines() if not line.startswith("import time:")]
    assert result.returncode == 0, "\n".join([result.stdout, *told])
    pattern = re.compile(r"^import time:.*\|\s*([\w.]+)\s*$", re.MULTILINE)
    return set(pattern.findall(result.stderr))


def test_lint_and_compile_do_not_import_torch(root: Path, tmp_path: Path) -> None:
    spec = str(root / "specs" / "flatworld_cycle.yaml")
    assert "torch" not in imported("lint", spec, cwd=tmp_path)
    assert "torch" not in imported("compile", spec, "-o", str(tmp_path / "out"), cwd=tmp_path)


@pytest.mark.parametrize("command", [["--help"], ["lint", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(command: list[str], tmp_path: Path) -> None:
    modules = imported(*command, cwd=tmp_path)
    assert "tiloilc.cli" in modules
    heavy = {"torch", "gymnasium", "networkx", "scipy", "matplotlib", "pygraphviz", "numpy", "dd"}
    assert sorted(modules & heavy) == []


def test_translate_needs_no_environment_and_no_learning(tmp_path: Path) -> None:
    modules = imported("translate", "G F (a & X F b) & G !z", cwd=tmp_path)
    heavy = {"torch", "gymnasium", "networkx", "scipy", "matplotlib", "pygraphviz"}
    assert sorted(modules & heavy) == []
