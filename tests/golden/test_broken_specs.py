"""Broken task files and what is said about them, to the letter.

`specs/NAME.yaml` is the task file and `specs/NAME.txt` what `tiloilc lint` prints about it. After a
wanted change look at each caret, then write what it prints now:
`tiloilc lint tests/golden/specs/NAME.yaml > tests/golden/specs/NAME.txt`
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tiloilc.diag import exit_status, render
from tiloilc.driver import lint

FOLDER = Path(__file__).parent / "specs"
SPECS = sorted(FOLDER.glob("*.yaml"))


def test_there_are_at_least_ten_and_each_has_its_text() -> None:
    assert len(SPECS) >= 10
    assert {p.stem for p in FOLDER.glob("*.txt")} == {p.stem for p in SPECS}


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_a_broken_spec_gets_its_text(
    path: Path, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(root)
    file = path.relative_to(root).as_posix()
    findings = lint(file)
    sources = {file: path.read_text(encoding="utf-8")}
    assert render(findings, "text", sources) == path.with_suffix(".txt").read_text(encoding="utf-8")
    assert exit_status(findings) == 1


def test_the_command_prints_the_same_and_exits_with_1(root: Path) -> None:
    files = [path.relative_to(root).as_posix() for path in SPECS]
    command = [sys.executable, "-m", "tiloilc", "lint", "--format", "json", *files]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    said = {d["file"] for d in json.loads(done.stdout)["diagnostics"] if d["severity"] == "error"}
    assert said == set(files)
