"""The back half of the compiler: the plan, the build folder, and reading it back."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tiloilc import __version__
from tiloilc.automaton import to_hoa, to_svg
from tiloilc.demos import DemoSet, save
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.driver.analysis import Analysis, analyse
from tiloilc.driver.environment import source_of
from tiloilc.label import Labeller, compile_predicates
from tiloilc.plan import Plan, Predicate, from_json, to_json
from tiloilc.spec import Demonstrations, PythonPredicate, Spec
from tiloilc.spec.laid import NOTHING, Laid
from tiloilc.writing import write_file

PLAN = "plan.json"
DEMOS = "demos.npz"

COPIED = ("spec", "automaton", "demonstrations")
"""Kinds of inputs of which a plan holds all that training needs."""

JOB = '''\
"""Trains the plan beside this file: python job.py [OPTIONS], as `tiloilc train`."""

import sys
from pathlib import Path

from tiloilc.cli import main

if __name__ == "__main__":
    main(["train", str(Path(__file__).resolve().parent), *sys.argv[1:]])
'''


@dataclass(frozen=True, eq=False)
class Compiled:
    """A task ready to be trained: the plan, its demonstrations, and findings short of errors."""

    plan: Plan
    demos: DemoSet
    diagnostics: tuple[Diagnostic, ...]


def lint(path: str | os.PathLike[str]) -> list[Diagnostic]:
    """All findings of the task file `path`, sorted by place. Nothing is written or trained."""
    try:
        return list(analyse(path).diagnostics)
    except CompileError as error:
        return sorted(error.diagnostics, key=Diagnostic.sort_key)


def compile_spec(path: str | os.PathLike[str], laid: Laid = NOTHING) -> Compiled:
    """Compile the task file `path`, with settings of demonstrations that are `laid` over it.

    Raises CompileError with all findings if one is an error.
    """
    analysis = analyse(path, laid=laid)
    if analysis.failed:
        raise CompileError(*analysis.diagnostics)
    return compiled(analysis)


def compiled(analysis: Analysis) -> Compiled:
    """The plan of a task without faults."""
    spec, ldba, stages = analysis.spec, analysis.ldba, analysis.stages
    assert not analysis.failed
    assert spec is not None
    assert ldba is not None
    assert stages is not None
    demos = analysis.demos or DemoSet(())
    digests = {"spec:" + analysis.document.path.name: _sha256(analysis.document.path)}
    digests |= _inputs(spec, analysis.document.path.parent)
    digests |= {DEMOS: hashlib.sha256(_demo_bytes(demos)).hexdigest()} if len(demos) else {}
    plan = Plan(
        name=spec.name,
        description=spec.description,
        environment=spec.environment,
        fields=dict(sorted(analysis.fields.items())),
        predicates=tuple(
            Predicate(name, python=p.python)
            if isinstance(p, PythonPredicate)
            else Predicate(name, text=p)
            for name, p in spec.propositions.items()
        ),
        formula=spec.formula or "",
        ldba=ldba,
        stages=stages,
        demonstrations=spec.demonstrations or Demonstrations(count=0),
        train=spec.train,
        evaluate=spec.evaluate,
        digests=dict(sorted(digests.items())),
        version=__version__,
        root=str(analysis.document.path.parent.resolve()),
    )
    return Compiled(plan, demos, analysis.diagnostics)


def write_build(result: Compiled, folder: Path) -> None:
    """Write the build folder: plan, automaton, picture, demonstrations, job.

    Each file is written under a temporary name and renamed, the plan last: a folder with a plan is
    whole. The same inputs give the same bytes.
    """
    plan = result.plan
    folder.mkdir(parents=True, exist_ok=True)
    (folder / PLAN).unlink(missing_ok=True)
    write_file(folder / "automaton.hoa", to_hoa(plan.ldba, name=plan.goal))
    write_file(folder / "automaton.svg", to_svg(plan.ldba, plan.stages, plan.goal))
    for name in (DEMOS, Path(DEMOS).with_suffix(".json").name):
        (folder / name).unlink(missing_ok=True)
    if len(result.demos):
        save(folder / DEMOS, result.demos)
    write_file(folder / "job.py", JOB)
    write_plan(plan, folder / PLAN)


def write_plan(plan: Plan, path: Path) -> None:
    """Write a plan; the task's folder is named relative to it, so both can be moved together."""
    root = os.path.relpath(plan.root, path.parent.resolve()) if plan.root else ""
    write_file(path, to_json(dataclasses.replace(plan, root=Path(root).as_posix())))


def load_plan(path: str | os.PathLike[str], *, of_run: bool = False) -> Plan:
    """The plan in a build folder, or in a file, with its `root` made absolute.

    A run stands on its own: its task file may have been edited since. Raises CompileError PLAN401
    for each input that changed, PLAN407 if the plan cannot be read.
    """
    file = plan_file(Path(path))
    plan = read_plan(file)
    held = COPIED if of_run else ()
    stale = list(_changed(plan, file.parent, held))
    if stale:
        raise CompileError(*(_stale(plan, name, file.parent) for name in stale))
    return plan


def read_plan(path: str | os.PathLike[str]) -> Plan:
    """Like `load_plan`, whatever became of its inputs."""
    file = plan_file(Path(path))
    try:
        text = file.read_bytes().decode()
    except (OSError, UnicodeDecodeError) as error:
        problem = "not UTF-8 text" if isinstance(error, ValueError) else str(error.strerror)
        problem = f"{file.as_posix()}: {problem}"
        raise CompileError(Diagnostic.of("PLAN407", problem=problem.lower())) from None
    plan = from_json(text, file.as_posix())
    return dataclasses.replace(plan, root=str((file.parent / plan.root).resolve()))


def labeller(plan: Plan) -> Labeller:
    """The propositions of `plan`, whose root is absolute, as one function of observations.

    Raises CompileError SPEC110 to SPEC120 if a predicate cannot be used any more.
    """
    python = {p.name: (Path(plan.root) / p.python).as_posix() for p in plan.predicates if p.python}
    return compile_predicates({p.name: p.text for p in plan.predicates}, plan.fields, python)


def plan_file(path: Path) -> Path:
    """The plan that a folder or a file stands for."""
    return path / PLAN if path.is_dir() else path


def _inputs(spec: Spec, root: Path) -> dict[str, str]:
    """Digests of the files that the task file names, as far as they are the user's own."""
    files = {
        f"python:{p.python.rpartition(':')[0]}"
        for p in spec.propositions.values()
        if isinstance(p, PythonPredicate)
    }
    if spec.demonstrations is not None and spec.demonstrations.file is not None:
        files.add(f"demonstrations:{spec.demonstrations.file}")
    if spec.automaton is not None:
        files.add(f"automaton:{spec.automaton}")
    own = source_of(spec.environment, root)
    if own is not None:
        files.add(f"environment:{own.relative_to(root).as_posix()}")
    return {key: _sha256(root / key.partition(":")[2]) for key in sorted(files)}


def _changed(plan: Plan, folder: Path, held: Sequence[str]) -> list[str]:
    """The inputs that differ from the plan's digests, as the user would name them.

    Kinds in `held` are not looked at. If a file whose content the plan holds is gone, nothing
    changes. What training itself needs must be there.
    """
    changed = []
    for key, digest in plan.digests.items():
        kind, _, name = key.rpartition(":")
        if kind in held:
            continue
        path = Path(plan.root) / name if kind else folder / name
        gone = not path.is_file()
        if kind not in COPIED if gone else _sha256(path) != digest:
            changed.append(name)
    return changed


def _stale(plan: Plan, name: str, folder: Path) -> Diagnostic:
    """PLAN401 of one input."""
    expected = (folder if name == DEMOS else Path(plan.root)) / name
    change, help = "changed", f"compile again: tiloilc compile {_spec_path(plan)}"
    if not expected.is_file():
        change, help = "was moved or deleted", f"put it back: {_seen_from_here(expected)}"
    return Diagnostic.of("PLAN401", path=name, change=change, help=help)


def _seen_from_here(path: Path) -> str:
    return Path(os.path.relpath(path)).as_posix()


def _spec_path(plan: Plan) -> str:
    name = next((k[5:] for k in plan.digests if k.startswith("spec:")), "SPEC")
    return _seen_from_here(Path(plan.root) / name)


def _demo_bytes(demos: DemoSet) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        save(Path(folder) / DEMOS, demos)
        return (Path(folder) / DEMOS).read_bytes()


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


__all__ = [
    "Compiled",
    "compile_spec",
    "compiled",
    "labeller",
    "lint",
    "load_plan",
    "plan_file",
    "read_plan",
    "write_build",
    "write_plan",
]
