"""Where a run comes from, and how to do it again."""

from __future__ import annotations

import json
import shlex

from tiloilc.diag import CompileError
from tiloilc.report.markup import Markup, concat, tag
from tiloilc.report.page import tables
from tiloilc.report.runs.run import Run
from tiloilc.spec import Demonstrations, read_spec
from tiloilc.spec.laid import beside, dotted

__all__ = ["duration", "provenance"]


def provenance(run: Run, name: str) -> Markup:
    """Versions, machine, digests and commands of a run; `name` is its head among several."""
    final = run.final
    digests = {"plan": run.plan_digest} if run.plan_digest else {}
    versions = dict(run.versions)
    if run.plan is not None:
        digests |= run.plan.digests
        versions = {"tiloilc": run.plan.version, **versions}
    body = [tag("h3", name)] if name else []
    body.append(tables.pairs(versions, kind="tight"))
    if final is not None and final.machine:
        body.append(tables.pairs(final.machine, kind="tight"))
    if final is not None and final.git_commit:
        digests = {"git commit": final.git_commit, **digests}
    body.append(tables.pairs(digests, kind="digests"))
    body.append(tag("h4", "To do it again"))
    body.append(tag("pre", tag("code", "\n".join(_commands(run))), class_="commands"))
    return concat(body)


def _commands(run: Run) -> list[str]:
    lines = []
    if run.final is not None and run.final.git_commit:
        commit = run.final.git_commit.removesuffix("-dirty")
        note = "" if commit == run.final.git_commit else "  # and what was not committed then"
        lines.append(f"git checkout {shlex.quote(commit)}{note}")
    changed = ""
    if run.total is not None and "steps" not in run.overrides:
        changed = f" --steps {run.total}"  # whatever the task file says
    changed += "".join(f" --set {shlex.quote(f'{k}={v}')}" for k, v in run.overrides.items())
    digests = {} if run.plan is None else run.plan.digests
    spec = next((key[5:] for key in digests if key.startswith("spec:")), f"{run.name}.yaml")
    laid = _laid(run, spec)
    if laid:  # only `run` takes demonstrations that the task file does not say
        return [*lines, f"tiloilc run {shlex.quote(spec)}{changed}{laid}"]
    lines.append(f"tiloilc compile {shlex.quote(spec)}")
    lines.append(f"tiloilc train {shlex.quote(f'build/{run.name}')}{changed}")
    lines.append(f"tiloilc eval {shlex.quote(f'runs/{run.name}/{run.folder}')}")
    lines.append(f"tiloilc report {shlex.quote(f'runs/{run.name}/{run.folder}')}")
    return lines


def _laid(run: Run, spec: str) -> str:
    """Options for demonstrations in which a run differs from its task file, where that is there."""
    try:
        given = read_spec(run.root / spec).spec.demonstrations
    except CompileError:
        return ""
    own = dotted(given or Demonstrations(count=0))  # as a plan has it
    shown = {name: value for name, value in run.shown.items() if own.get(name) != value}
    gone = {name: None for name in beside(own, shown) if name not in run.shown}
    texts = [
        f"{name}={value if isinstance(value, str) else json.dumps(value)}"
        for name, value in {**shown, **gone}.items()
    ]
    return "".join(f" --set {shlex.quote(text)}" for text in texts)


def duration(seconds: float) -> str:
    """Seconds as people say them."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h {minutes % 60} min"
