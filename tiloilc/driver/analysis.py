"""The front half of the compiler: a task file looked at from all sides, with every finding."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tiloilc.automaton.ldba import Ldba
from tiloilc.demos import (
    DemoSet,
    as_wanted,
    check_replays,
    check_shape,
    demonstrations_for,
    replay_all,
)
from tiloilc.diag import Diagnostic, Severity, SourceText, Span, counted
from tiloilc.driver.demonstrations import fit_findings, origin_findings
from tiloilc.driver.environment import Asked, ask
from tiloilc.driver.findings import Findings
from tiloilc.driver.formula import meaning, translated, unused
from tiloilc.driver.imported import import_findings, imported
from tiloilc.driver.settings import (
    backbone,
    backbone_findings,
    doubtful_findings,
    settings_findings,
)
from tiloilc.label import compile_predicates
from tiloilc.ltl import Parsed, parse
from tiloilc.plan import Stages, importable, stage_findings, stage_plan
from tiloilc.spec import Demonstrations, Document, Environment, Spec, examine_spec
from tiloilc.spec.laid import NOTHING, Laid

Labels = Callable[[NDArray[np.float32]], NDArray[np.int64]]

NEED_FIELDS = ("SPEC111", "SPEC112", "SPEC114", "SPEC120")
"""What cannot be said about a predicate while the fields of the observation are not known."""


@dataclass(frozen=True)
class Analysis:
    """What is known about a task; None is what a fault kept from being known."""

    document: Document
    spec: Spec | None
    asked: Asked | None
    fields: Mapping[str, tuple[int, int]]
    parsed: Parsed | None
    ldba: Ldba | None
    stages: Stages | None
    labels: Labels | None
    demos: DemoSet | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def failed(self) -> bool:
        """Whether there is an error."""
        return any(d.severity is Severity.ERROR for d in self.diagnostics)

    def setting(self, name: str) -> Span:
        """Where a setting of training is given, or the section that it could stand in."""
        return _setting(self.document, name)


def analyse(
    path: str | os.PathLike[str], given: DemoSet | None = None, laid: Laid = NOTHING
) -> Analysis:
    """Look at the task file `path`: everything that can be said of it without training.

    Demonstrations that are `given`, all of them, take the place of those of the task file; settings
    of demonstrations that are `laid` over it are as if it gave them. Raises CompileError only where
    there is nothing to look at (SPEC100, SPEC105, SPEC106).
    """
    document, spec, found = examine_spec(path)
    findings = Findings(list(found))
    if spec is not None and laid.values:
        spec = findings.attempt(partial(_laid_over, spec, laid, document))
    if spec is not None:
        shown = spec.demonstrations
        findings.add(settings_findings(spec.train, shown, lambda name: _setting(document, name)))
    parsed = findings.attempt(lambda: _parse(document)) if _has(document, "formula") else None
    ldba, stages = _automaton(parsed, document, findings)
    environment = _environment(document, spec)
    asked = None
    if environment is not None:
        asked = findings.attempt(lambda: ask(environment, document))
    fields = {**(asked.fields if asked else {}), **(spec.fields if spec else {})}
    if asked is not None and spec is not None:
        findings.add(_fit(spec, asked, document))
        if ldba is not None and stages is not None:
            tabular = backbone(spec.train, asked) == "tabular"
            findings.add(
                doubtful_findings(
                    spec.train,
                    ldba,
                    stages,
                    asked.greatest_entropy,
                    tabular,
                    lambda name: _setting(document, name),
                )
            )
    with importable(document.path.parent):
        known = asked is not None and (spec is not None or not document.has("observation"))
        labels = _labels(document, fields, known, findings)
        if labels and asked and not findings.failed:
            findings.attempt(lambda: labels(asked.seen))
        demos = None
        if spec and asked and labels and ldba and not findings.failed:
            span = _demonstrations_place(spec, document, laid) if given is None else None
            demos = _demonstrations(spec, asked, labels, ldba, document, findings, given, span)
    found_all = tuple(findings.ordered())
    return Analysis(document, spec, asked, fields, parsed, ldba, stages, labels, demos, found_all)


def _laid_over(spec: Spec, laid: Laid, document: Document) -> Spec:
    shown = laid.over(spec.demonstrations, document.path.parent)
    return spec.model_copy(update={"demonstrations": shown})


def _demonstrations_place(spec: Spec, document: Document, laid: Laid) -> Span | None:
    """Where the demonstrations are asked for; None if nowhere, or on the command line."""
    if spec.demonstrations is None:
        return None
    kind = spec.demonstrations.kind
    return laid.place(kind, document.span("demonstrations", kind))


def _has(document: Document, key: str) -> bool:
    """Whether there is such a text to read; what is none was reported as such."""
    try:
        return document.value_text(key).value != ""
    except KeyError:
        return False


def _parse(document: Document) -> Parsed:
    """The formula; where no propositions could be read, any name is one."""
    return parse(document.value_text("formula"), document.keys("propositions") or None)


def _automaton(
    parsed: Parsed | None, document: Document, findings: Findings
) -> tuple[Ldba | None, Stages | None]:
    """The automaton of the formula, or the one in the file that stands for it."""
    key = "formula" if parsed is not None else "automaton"
    span = document.span(key)
    if parsed is not None:
        findings.add(parsed.warnings)
        places = [document.key_span("propositions", name) for name in parsed.propositions]
        findings.add(unused(parsed, places))
        ldba = findings.attempt(lambda: translated(parsed, span))
    elif _has(document, "automaton") and not document.has("formula"):
        ldba = findings.attempt(lambda: imported(document))
    else:
        return None, None
    if ldba is None:
        return None, None
    said = list(import_findings(ldba, document) if parsed is None else meaning(parsed, ldba, span))
    findings.add(said)
    if any(d.severity is Severity.ERROR for d in said):
        return ldba, None
    stages = findings.attempt(lambda: stage_plan(ldba, span))
    if stages is not None:
        findings.add(stage_findings(ldba, stages, span))
    return ldba, stages


def _setting(document: Document, name: str) -> Span:
    """Where a setting is given, or the key of the section that it could stand in."""
    given = document.has("train", name)
    return document.span("train", name) if given else document.key_span("train")


def _environment(document: Document, spec: Spec | None) -> Environment | None:
    """The environment to ask; also that of a faulty task file, if it is no more than an id."""
    if spec is not None:
        return spec.environment
    try:
        name = document.value_text("environment", "id").value
    except KeyError:
        return None
    return None if document.has("environment", "kwargs") else Environment(id=name, horizon=1)


def _fit(spec: Spec, asked: Asked, document: Document) -> list[Diagnostic]:
    """JOB601, JOB604, JOB608 and SPEC120."""
    found = []
    if not asked.reproducible:
        span = document.span("environment", "id")
        help = "draw all randomness from `self.np_random`"
        found.append(Diagnostic.of("JOB601", span, environment=spec.environment.id, help=help))

    def place(name: str) -> Span:
        given = document.has("train", name)
        return document.span("train", name) if given else document.span("environment", "id")

    found += backbone_findings(spec.train, spec.demonstrations, asked, place)
    for name, (start, stop) in spec.fields.items():
        if stop > asked.dimensions:
            span = document.span("observation", name)
            size = counted(asked.dimensions, "component")
            found.append(
                Diagnostic.of("SPEC120", span, name=name, start=start, stop=stop, size=size)
            )
    return found


def _labels(
    document: Document,
    fields: Mapping[str, tuple[int, int]],
    complete: bool,
    findings: Findings,
) -> Labels | None:
    texts: dict[str, SourceText] = {}
    python: dict[str, SourceText] = {}
    for name in document.keys("propositions"):
        try:
            if document.has("propositions", name, "python"):
                reference = document.value_text("propositions", name, "python")
                python[name] = texts[name] = _beside(document, reference)
            else:
                texts[name] = document.value_text("propositions", name)
        except KeyError:
            return None
        if not texts[name].value:
            return None
    return findings.attempt(
        lambda: compile_predicates(texts, fields, python), unless=() if complete else NEED_FIELDS
    )


def _beside(document: Document, reference: SourceText) -> SourceText:
    """A path as the task file gives it, with the task file's folder before it."""
    value = (document.path.parent / reference.value).as_posix()
    places = (reference.places[0],) * len(value) + reference.places
    return SourceText(value, reference.file, places[-len(value) - 1 :])


def _demonstrations(
    spec: Spec,
    asked: Asked,
    labels: Labels,
    ldba: Ldba,
    document: Document,
    findings: Findings,
    given: DemoSet | None,
    span: Span | None,
) -> DemoSet | None:
    """The demonstrations as the plan takes them: checked, and cut after the wanted visits.

    `span` is where they are asked for.
    """
    wanted = spec.demonstrations
    if given is not None:
        wanted = wanted or Demonstrations()
        every = wanted.model_copy(update={"count": len(given)})
        demos = findings.attempt(lambda: as_wanted(given, every))
    elif wanted is not None:
        demos = findings.attempt(
            lambda: demonstrations_for(
                wanted,
                spec.environment,
                labels,
                ldba,
                name=spec.name,
                folder=document.path.parent,
                span=span,
            )
        )
    else:
        return None
    if not demos:
        return demos
    wrong = check_shape(demos, asked.dimensions, span) or list(fit_findings(demos, asked, span))
    findings.add(wrong)
    if wrong:
        return None
    findings.add(list(origin_findings(demos, spec.environment, span)))
    replayed = findings.attempt(lambda: replay_all(demos, labels, ldba, wanted.max_visits))
    if replayed is None:
        return None
    cut, replays = replayed
    findings.add(check_replays(replays, ldba, span))
    return cut


__all__ = ["Analysis", "analyse"]
