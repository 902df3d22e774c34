"""What made a record: which machine, which versions, which commit."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from importlib import metadata
from pathlib import Path


def machine() -> dict[str, object]:
    """What ran this, without names of hosts or people."""
    return {
        "system": platform.system(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
    }


def versions() -> dict[str, str]:
    """The versions of what decides results; MuJoCo's where a task has brought it in."""
    names = ["tiloilc", "torch", "numpy", "gymnasium"]
    names += [name for name in ("mujoco", "gymnasium-robotics") if _imported(name)]
    return {name: metadata.version(name) for name in names}


def _imported(distribution: str) -> bool:
    return distribution.replace("-", "_") in sys.modules


def git_commit(folder: Path) -> str | None:
    """The commit checked out in `folder`, None if there is none; `-dirty` if files differ."""
    return _git(folder, "describe", "--always", "--dirty", "--abbrev=40")


def git_time(folder: Path) -> int | None:
    """When that commit was made, in seconds since 1970; tells the later one of two records."""
    said = _git(folder, "show", "--no-patch", "--format=%ct", "HEAD")
    return int(said) if said is not None and said.isdecimal() else None


def _git(folder: Path, *arguments: str) -> str | None:
    """What git says of the checkout of `folder`; None if there is none, or no git."""
    command = ["git", "-C", str(folder), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None
