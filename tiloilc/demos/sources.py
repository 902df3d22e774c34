"""Where a task file's demonstrations come from: a file, Minari, the bundled ones, an expert."""

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
    """The demonstrations that a task file asks for, of its length; the caller checks them, and cuts
    them after visits.

    `file:` is relative to `folder`. `source: expert` takes the bundled demonstrations of the task
    `name` if they are of the same environment and the automaton accepts each; else it records.
    Raises CompileError DEMO500, DEMO505 (actions are wanted, but not all have some), DEMO506,
    DEMO511 (there are fewer than the task file says).
    """
    if wanted.file is not None:
        demos = load(folder / wanted.file, span)
    elif wanted.minari is not None:
        from tiloilc.demos.minari import from_minari

        demos = from_minari(wanted.minari, span)
    elif wanted.source == "expert":
        shipped = bundled(name)
        if shipped is None or not _fits(shipped, wanted, environment, labels, ldba):
            shipped = record_best(
                environment, labels, ldba, name=name, count=wanted.count, span=span
            )
        demos = shipped
    else:
        return DemoSet(())
    return as_wanted(demos, wanted, span)


def as_wanted(demos: DemoSet, wanted: Demonstrations, span: Span | None = None) -> DemoSet:
    """As many of `demos` as are wanted, of the wanted length, with actions or without.

    Raises CompileError DEMO505 if actions are wanted, but not all have some, DEMO511 if there are
    fewer than are asked for; by default there may be.
    """
    if len(demos) < wanted.count and "count" in wanted.model_fields_set:
        given = "1 demonstration" if len(demos) == 1 else f"{len(demos)} demonstrations"
        path, help = wanted.file or wanted.minari, "lower `count`, or record more"
        raise CompileError(
            Diagnostic.of("DEMO511", span, help=help, path=path, given=given, wanted=wanted.count)
        )
    demos = demos.take(wanted.count)
    if wanted.max_steps is not None:
        demos = demos.cut([wanted.max_steps] * len(demos))
    bare = [i for i, demo in enumerate(demos.episodes) if demo.actions is None]
    if wanted.actions == "recorded" and (bare or not demos):
        some = len(bare) < len(demos)
        carrier = f"demonstration {bare[0]} carries" if some else "the demonstrations carry"
        help = "use `actions: inferred`"
        raise CompileError(Diagnostic.of("DEMO505", span, help=help, carrier=carrier))
    return demos if wanted.actions == "recorded" else demos.without_actions()


def bundled(name: str) -> DemoSet | None:
    """The demonstrations that come with tiloilc for the task `name`, if there are any."""
    path = _bundled_path(name)
    return load(path) if path.is_file() else None


def record_best(
    environment: Environment,
    labels: Labels,
    ldba: Ldba,
    *,
    name: str,
    count: int,
    seed: int = 0,
    noise: float | None = None,
    laps: int | None = None,
    span: Span | None = None,
) -> DemoSet:
    """Record `count` episodes with the environment's expert for this task.

    An environment may have experts for several tasks. Taken is the one of whose demonstrations
    the automaton accepts most; of equals one that the task's `name` ends with, then the one that
    is accepted earliest. `noise` and `laps` take the place of their own. Raises CompileError
    DEMO506 if there is none.
    """
    names = expert_names(environment.id, environment.kwargs)
    if not names:
        raise CompileError(Diagnostic.of("DEMO506", span, named="", environment=environment.id))
    recorded = [
        record(
            environment.id,
            environment.kwargs,
            horizon=environment.horizon,
            expert=expert,
            count=count,
            seed=seed,
            noise=noise,
            laps=laps,
            span=span,
        )
        for expert in names
    ]

    def merit(demos: DemoSet) -> tuple[int, bool, float]:
        _, replays = replay_all(demos, labels, ldba, max_visits=1)
        steps = [len(run.states) for run in replays if run.visits]
        named = name.endswith(str(demos.meta["expert"]))
        return len(steps), named, -sum(steps) / max(len(steps), 1)

    return max(recorded, key=merit)


def _bundled_path(name: str) -> Path:
    from importlib.util import find_spec

    found = find_spec("tiloilc.tasks")
    assert found is not None
    assert found.origin is not None
    return Path(found.origin).parent / "demonstrations" / f"{Path(name).name}.npz"


def _fits(
    demos: DemoSet,
    wanted: Demonstrations,
    environment: Environment,
    labels: Labels,
    ldba: Ldba,
) -> bool:
    made = demos.meta.get("environment")
    asked = {
        "id": environment.id,
        "kwargs": environment.kwargs,
        "horizon": environment.horizon,
    }
    if made != asked or len(demos) < wanted.count:
        return False
    return all(run.visits > 0 for run in replay_all(demos, labels, ldba)[1])
