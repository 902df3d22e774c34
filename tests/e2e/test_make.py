"""The Makefile and the script of continuous integration do what they say."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e.conftest import environment


def make(*arguments: str, cwd: Path, timeout: float = 60) -> str:
    """What `make` prints, with the running environment as an installed one."""
    stamp = f"{sys.prefix}/.installed"
    command = ["make", "--no-print-directory", f"VENV={sys.prefix}", "-o", stamp, *arguments]
    result = subprocess.run(
        command,
        cwd=cwd,
        env=environment({"MAKEFLAGS": ""}),
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout + result.stderr


def test_make_help_names_every_target(root: Path) -> None:
    lines = (root / "Makefile").read_text(encoding="utf-8").splitlines()
    (phony,) = (line for line in lines if line.startswith(".PHONY:"))
    told = {line.split()[1] for line in make("help", cwd=root).splitlines()}
    assert told == set(phony.split()[1:])


def test_make_test_runs_everything_and_quick_all_but_the_slow(root: Path) -> None:
    whole = make("--dry-run", "test", cwd=root)
    assert "-m pytest" in whole
    assert "slow" not in whole
    assert '-m "not slow"' in make("--dry-run", "quick", cwd=root)


def test_ci_stops_at_the_first_failure_and_tells_how_long_each_step_took(
    root: Path, tmp_path: Path
) -> None:
    (tmp_path / ".ci").mkdir()
    script = tmp_path / ".ci" / "run"
    shutil.copy(root / ".ci" / "run", script)
    recipe = "setup check:\n\t@echo did $@\ntest:\n\t@echo did $@; exit 1\n"
    (tmp_path / "Makefile").write_text(recipe, encoding="utf-8")
    assert os.access(script, os.X_OK)

    def ci() -> tuple[int, str]:
        done = subprocess.run(
            ["bash", script], cwd="/", capture_output=True, text=True, timeout=60, check=False
        )
        return done.returncode, done.stdout

    status, output = ci()
    assert status == 2
    assert "==> make check: 0 s, status 0" in output
    assert "==> make test: 0 s, status 2" in output
    (tmp_path / "Makefile").write_text(recipe.replace("; exit 1", ""), encoding="utf-8")
    assert ci()[0] == 0
    (tmp_path / "Makefile").write_text("setup test:\ncheck:\n\t@false\n", encoding="utf-8")
    status, output = ci()
    assert status == 2
    assert "make test" not in output


@pytest.mark.slow
def test_make_run_does_a_job_from_the_task_file_to_the_report(root: Path, tmp_path: Path) -> None:
    shutil.copy(root / "Makefile", tmp_path)
    shutil.copytree(root / "specs", tmp_path / "specs")
    told = make("run", "SPEC=specs/grid_circular_easy.yaml", cwd=tmp_path, timeout=600)
    (report,) = (tmp_path / "runs").rglob("report.html")
    assert report.name in told
