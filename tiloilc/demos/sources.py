"""Where a task file's demonstrations come from: a file, the bundled ones, or an expert."""

from __future__ import annotations

from pathlib import Path

from tiloilc.automaton.ldba import Ldba
from tiloilc.demos.files import load
from tiloilc.demos.model import DemoSet
from tiloilc.demos.recording import expert_names, record
from tiloilc.demos.replay import Labels, replay_all
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.spec.model import Demonstrations, Environment


def demonstrations_for(
    wanted: Demonstrations,
    environment: Environment,
    labels: Labels,
    ldba: Ldba,
    *,
    name: str,
    folder: Path,
    span: Span | None = None,
) -> DemoSet:
    """The demonstrations that a task file asks for, whole; the caller cuts and checks them.

    `file:` is relative to `folder`. `source: expert` takes the bundled demonstrations of the task
    `name` if they are of the same environment; else it records. An environment may have experts
    for several tasks: the one whose demonstrations the automaton accepts most often is taken, the
    first of equals. Raises CompileError DEMO500, DEMO505 (actions wanted, none there), DEMO506.
    """
    if wanted.file is not None:
        demos = load(folder / wanted.file, span)
    elif wanted.source == "expert":
        shipped = bundled(name)
        fits = shipped is not None and _same_environment(shipped, environment)
        if shipped is not None and fits and len(shipped) >= wanted.count:
            demos = shipped
        else:
            demos = _from_best_expert(wanted, environment, labels, ldba, span)
    else:
        return DemoSet(())
    demos = demos.take(wanted.count)
    if wanted.actions == "recorded" and not demos.has_actions:
        raise CompileError(Diagnostic.of("DEMO505", span))
    return demos if wanted.actions == "recorded" else demos.without_actions()


def bundled(name: str) -> DemoSet | None:
    """The demonstrations that come with tiloilc for the task `name`, if there are any."""
    path = _bundled_path(name)
    return load(path) if path.is_file() else None


def _bundled_path(name: str) -> Path:
    from importlib.util import find_spec

    found = find_spec("tiloilc.tasks")
    assert found is not None
    assert found.origin is not None
    return Path(found.origin).parent / "demonstrations" / f"{Path(name).name}.npz"


def _same_environment(demos: DemoSet, environment: Environment) -> bool:
    made = demos.meta.get("environment")
    return (
        isinstance(made, dict)
        and made.get("id") == environment.id
        and made.get("kwargs") == environment.kwargs
        and made.get("horizon") == environment.horizon
    )


def _from_best_expert(
    wanted: Demonstrations,
    environment: Environment,
    labels: Labels,
    ldba: Ldba,
    span: Span | None,
) -> DemoSet:
    names = expert_names(environment.id, environment.kwargs)
    if not names:
        raise CompileError(Diagnostic.of("DEMO506", span, environment=environment.id))
    recorded = [
        record(
            environment.id,
            environment.kwargs,
            horizon=environment.horizon,
            expert=expert,
            count=wanted.count,
            span=span,
        )
        for expert in names
    ]

    def accepting_visits(demos: DemoSet) -> int:
        return sum(run.visits for run in replay_all(demos, labels, ldba)[1])

    return max(recorded, key=accepting_visits)
