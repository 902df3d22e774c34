"""What the verbs that take a task file or a plan share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tiloilc.cli.console import checked_suffix, fail, guests

if TYPE_CHECKING:
    from tiloilc.demos import DemoSet
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


def task_file(task: str) -> Path:
    """The path that `task` is, or the bundled task file of that name."""
    from importlib.resources import files

    path, ours = Path(task), Path(str(files("tiloilc.specs"))) / f"{task}.yaml"
    return ours if not path.exists() and ours.is_file() else path


def demonstrations_in(source: str) -> DemoSet:
    """The demonstrations of an .npz, or of a Minari dataset.

    Raises CompileError DEMO500 if they cannot be read.
    """
    from tiloilc.demos import load
    from tiloilc.demos.minari import from_minari

    is_file = source.endswith(".npz") or Path(source).is_file()
    return load(source) if is_file else from_minari(source)


def demonstrations_file(path: Path) -> Path:
    """A file that demonstrations can be written to. Raises Exit 2 if `path` is none.

    Its name must be that of an .npz, and the JSON beside it no file of something else.
    """
    from tiloilc.demos import foreign_sidecar

    checked_suffix(path, "demonstrations are kept as", ".npz")
    if other := foreign_sidecar(path):
        what = "which goes beside it, is there already and not of demonstrations"
        raise fail(f"`{path.as_posix()}` cannot be written: `{other.as_posix()}`, {what}")
    return path


def prepare_drawing() -> None:
    """Choose what MuJoCo draws with where there is no screen: before it is imported."""
    from importlib.util import find_spec

    if find_spec("mujoco") is not None:
        import tiloilc.tasks.robots  # noqa: F401
