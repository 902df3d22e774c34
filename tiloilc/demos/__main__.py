"""`python -m tiloilc.demos flatworld_cycle`: record a task's demonstrations with its expert.

Reads the task file (a path, or the name of a bundled one), lets the environment's experts act, and
writes the demonstrations that the task's automaton likes best.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tiloilc.demos.files import save
from tiloilc.demos.model import DemoSet
from tiloilc.demos.recording import published_fields
from tiloilc.demos.sources import record_best
from tiloilc.diag import CompileError, SourceText, render
from tiloilc.spec import SpecFile, read_spec


def main(arguments: Sequence[str] | None = None) -> int:
    """Record the demonstrations of each task file named; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tiloilc.demos", description=__doc__)
    parser.add_argument("tasks", nargs="+", metavar="TASK", help="a task file, or a bundled task")
    parser.add_argument("-o", "--out", type=Path, default=Path(), help="folder to write to")
    parser.add_argument("--count", type=int, default=5, help="episodes of each")
    parser.add_argument("--seed", type=int, default=0, help="the first episode's seed")
    chosen = parser.parse_args(arguments)
    chosen.out.mkdir(parents=True, exist_ok=True)
    sources: dict[str, str] = {}
    try:
        for task in chosen.tasks:
            file = read_spec(task_file(task))
            sources[file.file] = file.text
            demos = recorded(file, chosen.count, chosen.seed)
            path = chosen.out / f"{file.spec.name}.npz"
            save(path, demos)
            steps = sum(demo.steps for demo in demos.episodes)
            sys.stderr.write(f"{path}: {len(demos)} episodes, {steps} steps\n")
    except CompileError as error:
        sys.stderr.write(render(error.diagnostics, "text", sources))
        return 1
    return 0


def recorded(file: SpecFile, count: int, seed: int) -> DemoSet:
    """Demonstrations of a task file's environment by the expert that fits its automaton.

    Raises CompileError as the stages it calls do.
    """
    from tiloilc.automaton import load_hoa, translate
    from tiloilc.label import compile_predicates
    from tiloilc.ltl import parse

    spec = file.spec
    fields = {**published_fields(spec.environment.id, spec.environment.kwargs)}
    for name, place in spec.observation.items():
        fields[name] = (place, place + 1) if isinstance(place, int) else place
    names = tuple(spec.propositions)
    texts: dict[str, SourceText | str] = {}
    python: dict[str, str] = {}
    for name, predicate in spec.propositions.items():
        if isinstance(predicate, str):
            texts[name] = file.value_text("propositions", name)
        else:
            python[name] = (file.path.parent / predicate.python).as_posix()
            texts[name] = file.value_text("propositions", name, "python")
    labels = compile_predicates(texts, fields, python)
    if spec.automaton is not None:
        ldba = load_hoa(file.path.parent / spec.automaton, names, span=file.span("automaton")).ldba
    else:
        ldba = translate(parse(file.value_text("formula"), names).formula, names)
    return record_best(spec.environment, labels, ldba, name=spec.name, count=count, seed=seed)


def task_file(task: str) -> Path:
    """The path that `task` is, or the bundled task file of that name."""
    from importlib.util import find_spec

    found = find_spec("tiloilc.specs")
    assert found is not None
    assert found.origin is not None
    ours = Path(found.origin).parent / f"{task}.yaml"
    return ours if not Path(task).exists() and ours.exists() else Path(task)


if __name__ == "__main__":
    sys.exit(main())
