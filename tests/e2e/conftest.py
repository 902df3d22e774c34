"""Running the installed program as users do."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

Run = Callable[..., "subprocess.CompletedProcess[str]"]


def environment(extra: Mapping[str, str] | None = None) -> dict[str, str]:
    """The environment of programs under test: this interpreter's commands first, no colours."""
    commands = str(Path(sys.executable).parent)
    path = os.pathsep.join([commands, os.environ.get("PATH", os.defpath)])
    return {**os.environ, "PATH": path, "NO_COLOR": "1", **(extra or {})}


@pytest.fixture
def tiloilc() -> Run:
    """Call `tiloilc(*arguments, cwd=…, status=0)`: runs it, checks the status, gives the result."""

    def run(
        *arguments: str | Path,
        cwd: Path | None = None,
        status: int = 0,
        timeout: float = 600,
        env: Mapping[str, str] | None = None,
    ) -> subprocess.CompletedProcess[str]:
        result = subprocess.run(
            [sys.executable, "-m", "tiloilc", *map(str, arguments)],
            cwd=cwd,
            env=environment(env),
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        told = f"tiloilc {' '.join(map(str, arguments))}\n{result.stdout}\n{result.stderr}"
        assert result.returncode == status, told
        return result

    return run
