"""What is recorded already, and records from elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from functools import cache
from pathlib import Path

from pydantic import ValidationError

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.evaluate import Record, append, read
from tiloilc.plan import digest
from tiloilc.spec import Demonstrations
from tiloilc.spec.presets import PRESETS
from tiloilc.sweep.experiments import Experiment, record_file
from tiloilc.sweep.model import OWN

WHERE = ("checkpoint_every", "compile", "device")
"""Settings that move no more than last digits of results."""


class Same(StrEnum):
    """What a record must have in common with what is asked for, so that its seed is done."""

    PLAN = "plan"
    COMMIT = "commit"
    SPEC = "spec"


def recorded(
    experiments: Sequence[Experiment], same: Same, commit: str | None
) -> list[dict[int, Record]]:
    """Of each experiment the records of its seeds, one a seed, from the files it is kept in.

    A record is of the same plan if its plan differs in nothing but which seeds were trained
    together; of the same spec if task file, demonstrations, steps and settings are the same,
    whatever has become of this program. Where several commits made one seed, that of `commit`
    counts, else the latest. Raises CompileError RUN701 for a damaged file.
    """
    files: dict[Path, list[Record]] = {}
    found = []
    for one in experiments:
        if one.records not in files:
            files[one.records] = read(one.records) if one.records.exists() else []
        found.append(_of(one, files[one.records], same, commit))
    return found


def _of(
    one: Experiment, records: Iterable[Record], same: Same, commit: str | None
) -> dict[int, Record]:
    spec = next((v for k, v in one.plan.digests.items() if k.startswith("spec:")), None)
    wanted = {
        "name": one.plan.name,
        "algorithm": one.settings.algorithm,
        "preset": one.settings.preset,
        "interrupted": False,
    }
    settings = _chosen(one.settings.overrides())

    @cache
    def digest_of(seeds: range) -> str:
        return digest(one.plan_of(seeds))

    kept: dict[int, list[tuple[bool, int, Record]]] = {}
    for record in records:
        fields = record.fields
        seed, overrides = fields.get("seed"), fields.get("overrides")
        if not isinstance(seed, int) or seed not in one.seeds or not isinstance(overrides, dict):
            continue
        if any(fields.get(key) != value for key, value in wanted.items()):
            continue
        if same is Same.SPEC:
            alike = fields.get("spec_digest") == spec and _chosen(overrides) == settings
            alike = alike and fields.get("steps") == one.steps
            alike = alike and _shown_alike(fields.get("demonstrations"), one)
        else:
            alike = fields.get("plan_digest") == digest_of(_trained(overrides, one))
        ours = fields.get("git_commit") == commit
        if alike and (ours or same is not Same.COMMIT):
            made = fields.get("git_time")
            kept.setdefault(seed, []).append((ours, made if isinstance(made, int) else 0, record))
    return {seed: max(found, key=lambda rank: rank[:2])[2] for seed, found in kept.items()}


def _shown_alike(given: object, one: Experiment) -> bool:
    """Whether a record's demonstrations are asked for; those of old say nothing of theirs."""
    if given is None:
        return not one.shown
    try:
        return Demonstrations.model_validate(given) == one.plan.demonstrations
    except ValidationError:  # of a version that knew more of them
        return False


def _trained(overrides: Mapping[str, object], one: Experiment) -> range:
    """The seeds that were trained together with a record's."""
    preset = PRESETS[one.settings.preset]
    count, first = (overrides.get(key, preset[key]) for key in OWN)
    if not isinstance(count, int) or not isinstance(first, int):
        return one.seeds
    return range(first, first + count)


def _chosen(overrides: Mapping[str, object]) -> dict[str, object]:
    """What was chosen of how to learn: not the seeds, nor where they were trained."""
    return {key: _plain(v) for key, v in overrides.items() if key not in (*OWN, *WHERE)}


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


def merge(paths: Sequence[Path], pattern: str) -> dict[Path, int]:
    """Add the records of files and folders to those of `pattern`; how many each file then has.

    Raises CompileError RUN701 if there is no such file, or one is damaged; then nothing is added.
    """
    parts: dict[Path, list[Record]] = {}
    for record in read(*(file for path in paths for file in _files(path))):
        fields = record.fields
        file = record_file(pattern, str(fields.get("name")), str(fields.get("algorithm")))
        parts.setdefault(file, []).append(record)
    return {file: append(file, records) for file, records in sorted(parts.items())}


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    found = sorted([*path.glob("*.jsonl.gz"), *path.glob("*.jsonl")])
    if not found:
        problem = "the folder has no *.jsonl.gz"
        raise CompileError(Diagnostic.of("RUN701", path=path.as_posix(), problem=problem))
    return found
