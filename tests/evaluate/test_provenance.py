"""What is told of where a record was made."""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from tiloilc.evaluate.provenance import git_commit, git_time, machine, versions


def test_machine_and_versions_name_no_host() -> None:
    assert platform.node() not in json.dumps([machine(), versions()]).replace('"', " ").split()
    assert {"tiloilc", "torch", "numpy", "gymnasium"} <= set(versions())


def test_what_a_task_brought_in_is_among_the_versions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "mujoco", raising=False)
    assert "mujoco" not in versions()
    monkeypatch.setitem(sys.modules, "mujoco", sys)
    assert versions()["mujoco"].startswith("3.")


def test_a_folder_outside_git_has_no_commit(tmp_path: Path) -> None:
    assert git_commit(tmp_path) is None
    assert git_commit(tmp_path / "missing") is None
    assert git_time(tmp_path) is None


def test_a_commit_has_its_time(tmp_path: Path) -> None:
    at = {"GIT_COMMITTER_DATE": "@1700000000 +0000", "GIT_AUTHOR_DATE": "@1600000000 +0000"}
    for arguments in (["init", "-q"], ["commit", "-q", "--allow-empty", "-m", "x"]):
        me = ["-c", "user.name=x", "-c", "user.email=x@example.org"]
        subprocess.run(
            ["git", "-C", str(tmp_path), *me, *arguments], env={**os.environ, **at}, check=True
        )
    assert git_time(tmp_path) == 1_700_000_000
