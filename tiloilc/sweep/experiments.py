"""Specs with settings, compiled and checked before anything runs; and the jobs they make."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from tiloilc.diag import CompileError, Diagnostic, Severity, Span
from tiloilc.driver import (
    Analysis,
    Compiled,
    analyse,
    backbone,
    backbone_findings,
    compiled,
    doubtful_findings,
    settings_findings,
)
from tiloilc.plan import Plan, digest
from tiloilc.spec.laid import Laid
from tiloilc.spec.settings import Settings
from tiloilc.sweep.model import RECORD_ENDINGS
from tiloilc.sweep.request import Request, Variant


@dataclass(frozen=True, eq=False)
class Experiment:
    """One task with one set of settings: what a row of the final table is of.

    `changes` are the settings of training that differ from the task file, without the seeds;
    `shown` are those of demonstrations, with which `task` was compiled. `records` is the file in
    which its records are kept.
    """

    spec: Path
    task: Compiled
    changes: Mapping[str, object]
    shown: Mapping[str, object]
    seeds: range
    seeds_per_job: int | None
    records: Path

    @cached_property
    def plan(self) -> Plan:
        """The plan of all its seeds together."""
        return self.plan_of(self.seeds)

    def plan_of(self, seeds: range) -> Plan:
        """The plan by which these seeds are trained together."""
        train = self.task.plan.train.override({**self.changes, **agents(seeds)})
        return dataclasses.replace(self.task.plan, train=train)

    @cached_property
    def settings(self) -> Settings:
        """Its settings, resolved."""
        return self.plan.train

    @property
    def steps(self) -> int:
        """Environment steps of a seed."""
        return self.settings.steps_taken

    @property
    def words(self) -> str:
        """What tells it from others of its task: the algorithm and what was changed."""
        apart = ("algorithm", "steps")  # these are told beside it
        changed = {**self.changes, **self.shown}
        others = [f"{k}={_short(v)}" for k, v in changed.items() if k not in apart]
        return " ".join([self.settings.algorithm, *others])


@dataclass(frozen=True)
class Job:
    """Some seeds of an experiment, trained together by one program. `number` is the experiment's.

    `id` names its folder: the same plan has the same in every sweep. `cost` is in steps of a seed.
    """

    id: str
    number: int
    seeds: range
    changes: Mapping[str, object]
    cost: int


def agents(seeds: range) -> dict[str, object]:
    """The settings that say which seeds there are."""
    return {"seeds": len(seeds), "first_seed": seeds.start}


def check(requests: Iterable[Request]) -> tuple[list[Experiment], list[Diagnostic]]:
    """All experiments, in the asked order and each once, and findings short of errors.

    Every task file is compiled, once with each set of settings of demonstrations, and every set of
    settings tried on it. Raises CompileError with all that is wrong.
    """
    found: list[Diagnostic] = []
    analyses: dict[tuple[Path, str], tuple[Analysis, Compiled] | None] = {}
    experiments: dict[str, Experiment] = {}
    for request in requests:
        for spec in request.specs:
            for variant in request.variants:
                key = spec.resolve(), json.dumps(variant.laid.values, sort_keys=True)
                if key not in analyses:
                    analyses[key] = _compile(spec, variant.laid, found)
                known = analyses[key]
                if known is None:
                    continue
                said = list(_findings(known[0], variant, request))
                found += said
                if any(d.severity is Severity.ERROR for d in said):
                    continue
                one = _experiment(spec, known[1], variant, request)
                experiments.setdefault(digest(one.plan), one)
    found = list(dict.fromkeys(found))
    if any(d.severity is Severity.ERROR for d in found):
        raise CompileError(*found)
    return list(experiments.values()), found


def jobs_of(
    experiments: Sequence[Experiment], recorded: Sequence[Iterable[int]], salt: str = ""
) -> list[Job]:
    """The jobs for the seeds that are not recorded yet, each once, the longest first.

    Seeds are cut into the same parts whatever is recorded, so that a sweep that goes on finds the
    folders of its unfinished jobs. `salt` keeps jobs apart that are not to share a folder.
    """
    jobs = []
    begun: dict[tuple[str, Path], set[int]] = {}  # two sweep files can ask for the same seeds
    for number, (one, seeds) in enumerate(zip(experiments, recorded, strict=True)):
        have = begun.setdefault((digest(one.plan_of(range(1))), one.records), set())
        have |= set(seeds)
        for part in _parts(one.seeds, one.seeds_per_job or len(one.seeds)):
            for missing in _runs([seed for seed in part if seed not in have]):
                have |= set(missing)
                plan = one.plan_of(missing)
                hashed = hashlib.sha256((digest(plan) + salt).encode()).hexdigest()
                jobs.append(
                    Job(
                        f"{plan.name}-{plan.train.algorithm}-{hashed[:12]}",
                        number,
                        missing,
                        {**one.changes, **agents(missing)},
                        max(plan.train.steps_taken, 1) * len(missing),
                    )
                )
    return sorted(jobs, key=lambda job: -job.cost)


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else json.dumps(value).strip('"')


def _compile(spec: Path, laid: Laid, found: list[Diagnostic]) -> tuple[Analysis, Compiled] | None:
    """The task with these demonstrations, or None after its errors were told."""
    try:
        analysis = analyse(spec, laid=laid)
    except CompileError as error:
        found += error.diagnostics
        return None
    found += analysis.diagnostics
    return None if analysis.failed else (analysis, compiled(analysis))


def _findings(analysis: Analysis, variant: Variant, request: Request) -> Iterator[Diagnostic]:
    """What is wrong or strange about a variant's settings in this task, with what seeds it has."""
    spec, asked, ldba, stages = analysis.spec, analysis.asked, analysis.ldba, analysis.stages
    assert spec is not None
    assert asked is not None
    assert ldba is not None
    assert stages is not None
    changes, places = {**variant.train, **request.agents}, {**variant.places, **request.places}
    if not changes:
        return
    settings = spec.train.override(changes)

    def place(name: str) -> Span | None:
        return places[name] if name in places else analysis.setting(name)

    yield from settings_findings(settings, spec.demonstrations, place)
    yield from backbone_findings(settings, spec.demonstrations, asked, place)
    tabular = backbone(settings, asked) == "tabular"
    yield from doubtful_findings(settings, ldba, stages, asked.greatest_entropy, tabular, place)


def _experiment(spec: Path, task: Compiled, variant: Variant, request: Request) -> Experiment:
    train = task.plan.train
    seeds = train.seeds if request.seeds is None else request.seeds
    first = train.first_seed if request.first_seed is None else request.first_seed
    algorithm = str(variant.settings.get("algorithm", train.algorithm))
    return Experiment(
        spec,
        task,
        variant.train,
        variant.laid.values,
        range(first, first + seeds),
        request.seeds_per_job,
        record_file(request.records, task.plan.name, algorithm),
    )


def record_file(pattern: str, name: str, algorithm: str) -> Path:
    """The file for records of a task and an algorithm: one a task, if the pattern is a folder."""
    if not pattern.endswith(RECORD_ENDINGS):
        return Path(pattern) / f"{name}.jsonl.gz"
    return Path(pattern.replace("{name}", name).replace("{algorithm}", algorithm))


def _parts(seeds: range, size: int) -> Iterator[range]:
    for start in range(seeds.start, seeds.stop, size):
        yield range(start, min(start + size, seeds.stop))


def _runs(seeds: Sequence[int]) -> Iterator[range]:
    """The seeds as stretches without a gap."""
    start = 0
    for i in range(1, len(seeds) + 1):
        if i == len(seeds) or seeds[i] != seeds[i - 1] + 1:
            yield range(seeds[start], seeds[i - 1] + 1)
            start = i
