"""The wheel, installed outside the checkout, is the whole program."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

SOURCES = {
    "tiloilc": "tiloilc",
    "tasks": "tiloilc/tasks",
    "specs": "tiloilc/specs",
    "docs/diagnostics": "tiloilc/diagnostics",
}
"""Folders of the checkout whose files travel in the wheel, and where they are in it."""


def run(*command: str | Path, cwd: Path) -> str:
    """Standard output of a command that must succeed, in an environment without PYTHONPATH."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    result = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env=clean,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    told = f"{' '.join(map(str, command))}\n{result.stdout}\n{result.stderr}"
    assert result.returncode == 0, told
    return result.stdout


@dataclass(frozen=True)
class Installed:
    """A wheel and a virtual environment that has it; `work` is an empty folder."""

    wheel: Path
    python: Path
    package: Path
    work: Path

    def tiloilc(self, *arguments: str | Path) -> str:
        """What the installed console script prints."""
        return run(self.python.with_name("tiloilc"), *arguments, cwd=self.work)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Build from a copy of the sources, install where only our dependencies can be seen.

    The new environment sees the packages of the running one through a path file. That file is
    read as a list of folders, so the path files *of* those packages, an editable install of this
    checkout among them, have no effect there.
    """
    root = Path(__file__).resolve().parents[2]
    base = tmp_path_factory.mktemp("wheel")
    source, work = base / "source", base / "work"
    source.mkdir()
    work.mkdir()
    for name in SOURCES:
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(root / name, source / name, symlinks=True, ignore=ignored)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(root / name, source)

    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    run(*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", base, source, cwd=base)
    (wheel,) = base.glob("tiloilc-*.whl")

    place = base / "venv"
    venv.EnvBuilder(with_pip=False, symlinks=os.name != "nt").create(place)
    scripts = "Scripts" if os.name == "nt" else "bin"
    python = place / scripts / Path(sys.executable).name
    paths = {"base": str(place), "platbase": str(place)}
    packages = Path(sysconfig.get_path("purelib", vars=paths))
    here = sysconfig.get_paths()
    seen = dict.fromkeys((here["purelib"], here["platlib"]))
    (packages / "dependencies.pth").write_text("\n".join(seen) + "\n", encoding="utf-8")
    run(*pip, "--python", python, "install", "--no-deps", "--no-index", wheel, cwd=base)
    return Installed(wheel, python, packages / "tiloilc", work)


def test_every_source_file_is_in_the_wheel(installed: Installed, root: Path) -> None:
    expected = set()
    for name, prefix in SOURCES.items():
        for folder, _, files in os.walk(root / name):
            expected |= {
                str(Path(prefix) / (Path(folder) / file).relative_to(root / name))
                for file in files
                if "__pycache__" not in folder
            }
    with zipfile.ZipFile(installed.wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert sorted(expected - packed) == []
    assert sorted(packed - expected) == []


def test_nothing_of_the_checkout_is_seen(installed: Installed) -> None:
    modules = "tiloilc, tiloilc.cli, tiloilc.specs, tiloilc.tasks"
    program = f"import {modules}\nprint(*(m.__file__ for m in ({modules})), sep='\\n')"
    for place in run(installed.python, "-c", program, cwd=installed.work).splitlines():
        assert Path(place).is_relative_to(installed.package), place


def test_the_wheel_is_typed(installed: Installed) -> None:
    assert (installed.package / "py.typed").is_file()


def test_the_installed_program_compiles_a_bundled_task(installed: Installed) -> None:
    spec = installed.package / "specs" / "flatworld_cycle.yaml"
    installed.tiloilc("lint", spec)
    assert installed.tiloilc("explain", "LTL203").startswith("error[LTL203]")
    installed.tiloilc("compile", spec, "-o", installed.work / "out")
    plan = json.loads((installed.work / "out" / "plan.json").read_text(encoding="utf-8"))
    assert plan["name"] == "flatworld_cycle"
    assert (installed.work / "out" / "demos.npz").is_file()
    assert (installed.work / "out" / "automaton.hoa").read_text(encoding="utf-8").startswith("HOA:")


def test_the_installed_program_makes_a_new_task_that_lints(installed: Installed) -> None:
    installed.tiloilc("init", "parcel")
    (spec,) = (installed.work / "parcel").glob("*.yaml")
    installed.tiloilc("lint", spec)
