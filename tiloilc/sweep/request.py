"""What is asked for: by sweep files, by spec paths and options, or by both."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from glob import glob, has_magic
from itertools import product
from pathlib import Path

from tiloilc.diag import CompileError, Diagnostic, Severity, Span
from tiloilc.spec.base import Model
from tiloilc.spec.laid import DEMO_FILE, PREFIX, Laid, beside, exclusive, seen_from
from tiloilc.spec.read import Document, examine_document, file_text, read_document
from tiloilc.sweep.model import OWN, SWEEP_FILE, Sweep, given

RECORDS = "results"
"""The folder in which records are kept, unless told otherwise."""

_OURS = re.compile(r"^(?:specs|algorithms|overrides|grid|seeds_per_job)[ \t]*:", re.MULTILINE)
_TASKS = re.compile(r"^(?:environment|propositions|formula)[ \t]*:", re.MULTILINE)


@dataclass(frozen=True)
class Variant:
    """One set of settings, and where in a sweep file each is given; None: on the command line.

    Those whose names begin with `demonstrations.` are of the task file's demonstrations, and a
    relative file of them is from the working folder; all others are of training.
    """

    settings: Mapping[str, object]
    places: Mapping[str, Span | None]

    def then(self, other: Variant) -> Variant:
        """This one with what the other gives, which takes the place of what this one says."""
        settings = {**beside(self.settings, other.settings), **other.settings}
        places = {**self.places, **other.places}
        return Variant(settings, {name: places[name] for name in settings})

    @property
    def train(self) -> Mapping[str, object]:
        """The settings of training."""
        return {k: v for k, v in self.settings.items() if not k.startswith(PREFIX)}

    @property
    def laid(self) -> Laid:
        """The settings of demonstrations."""
        values = {k: v for k, v in self.settings.items() if k.startswith(PREFIX)}
        return Laid(values, {name: self.places[name] for name in values})


@dataclass(frozen=True)
class Request:
    """Specs × variants × seeds. What is None is as the spec says; `records` is a pattern.

    `places` says where the seeds are given, if here: in a sweep file; None: on the command line.
    """

    specs: tuple[Path, ...]
    variants: tuple[Variant, ...]
    seeds: int | None = None
    first_seed: int | None = None
    seeds_per_job: int | None = None
    records: str = RECORDS
    places: Mapping[str, Span | None] = field(default_factory=dict)

    @property
    def agents(self) -> Mapping[str, int]:
        """The settings that say which seeds there are, as far as they are given."""
        asked = {"seeds": self.seeds, "first_seed": self.first_seed}
        return {name: number for name, number in asked.items() if number is not None}


@dataclass(frozen=True)
class Options:
    """What the command line gives: it takes the place of what a sweep file says."""

    algorithms: tuple[str, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    seeds: int | None = None
    first_seed: int | None = None
    seeds_per_job: int | None = None
    records: str | None = None


def requests(paths: Sequence[Path], options: Options) -> list[Request]:
    """The request of each sweep file among `paths`, and one for all task files.

    Raises CompileError with what is wrong with sweep files, and files that cannot be read.
    """
    found, specs, errors = list[Request](), list[Path](), list[Diagnostic]()
    for path in dict.fromkeys(paths):
        try:
            text = file_text(path)
            if is_sweep(text):
                found.append(of_file(path, text, options))
            else:
                specs.append(path)
        except CompileError as error:
            errors += error.diagnostics
    if errors:
        raise CompileError(*errors)
    if specs:
        found.append(of_specs(tuple(specs), options))
    return found


def is_sweep(text: str) -> bool:
    """Whether a text is meant as a sweep file, not as a task file; also where it is no YAML."""
    return bool(_OURS.search(text)) and not _TASKS.search(text)


def of_specs(specs: tuple[Path, ...], options: Options) -> Request:
    """The request of task files and options alone."""
    return Request(
        specs,
        tuple(_variants([Variant({}, {})], dict.fromkeys(options.algorithms), options)),
        options.seeds,
        options.first_seed,
        options.seeds_per_job,
        options.records or RECORDS,
        dict(_said(options)),
    )


def of_file(path: Path, text: str, options: Options = Options()) -> Request:
    """The request of a sweep file. Raises CompileError with all that is wrong with it."""
    document, found = read_document(text, path.as_posix(), SWEEP_FILE)
    sweep, findings = examine_document(document, SWEEP_FILE, found)
    if sweep is not None:
        findings = (*findings, *_clashes(sweep, document))
        specs, missing = _specs(sweep, document)
        findings = (*findings, *missing)
    if sweep is None or any(f.severity is Severity.ERROR for f in findings):
        raise CompileError(*sorted(findings, key=Diagnostic.sort_key))
    records = (path.parent / sweep.records).as_posix() if sweep.records else RECORDS
    sets = _sets(sweep, document)
    if sweep.steps is not None:
        steps = Variant({"steps": sweep.steps}, {"steps": document.span("steps")})
        sets = [steps.then(one) for one in sets]
    listed = enumerate(sweep.algorithms or ())
    algorithms = {name: document.span("algorithms", i) for i, name in listed}
    return Request(
        specs,
        tuple(_variants(sets, dict.fromkeys(options.algorithms) or algorithms, options)),
        _either(options.seeds, sweep.seeds),
        _either(options.first_seed, sweep.first_seed),
        _either(options.seeds_per_job, sweep.seeds_per_job),
        options.records or records,
        {**dict(_said(sweep, document.span)), **dict(_said(options))},
    )


def _said(
    about: Sweep | Options, place: Callable[[str], Span | None] = lambda name: None
) -> Iterator[tuple[str, Span | None]]:
    """What is said of seeds, and where."""
    return ((name, place(name)) for name in OWN if getattr(about, name) is not None)


def _either(first: int | None, second: int | None) -> int | None:
    return second if first is None else first


def _variants(
    sets: Sequence[Variant], algorithms: Mapping[str, Span | None], options: Options
) -> Iterator[Variant]:
    """Each set with each algorithm; one that names its own is run with that alone."""
    last = Variant(options.settings, dict.fromkeys(options.settings))
    first = [Variant({"algorithm": name}, {"algorithm": at}) for name, at in algorithms.items()]
    for one in sets:
        own = "algorithm" in {*one.settings, *options.settings}
        for named in first if first and not own else [Variant({}, {})]:
            yield named.then(one).then(last)


def _sets(sweep: Sweep, document: Document) -> list[Variant]:
    """Every set of settings with every combination of the grid's values, as written."""
    home = document.path.parent
    sets = [
        Variant(
            {name: _seen(name, value, home) for name, value in given(one).items()},
            {name: document.span("overrides", i, name) for name in given(one)},
        )
        for i, one in enumerate(sweep.overrides)
    ]
    axes = [
        [
            Variant({name: _seen(name, value, home)}, {name: document.span("grid", name, i)})
            for i, value in enumerate(values)
        ]
        for name, values in _axes(sweep.grid).items()
    ]
    return [
        reduce(Variant.then, picks, one)
        for one in sets or [Variant({}, {})]
        for picks in product(*axes)
    ]


def _seen(name: str, value: object, home: Path) -> object:
    """A value of a sweep file in the folder `home`: a file as the working folder sees it."""
    return seen_from(Path(), Path(str(value)), home) if name == DEMO_FILE else value


def _axes(grid: Model | None) -> dict[str, list[object]]:
    if grid is None:
        return {}
    return {name: values for name, values in given(grid).items() if isinstance(values, list)}


def _clashes(sweep: Sweep, document: Document) -> Iterator[Diagnostic]:
    """SPEC108 for settings that exclude each other in what is combined: a set and the grid."""
    grid = [(f"grid.{name}", ("grid", name)) for name in _axes(sweep.grid)]
    sets = [
        [(f"overrides[{i}].{name}", ("overrides", i, name)) for name in given(one)]
        for i, one in enumerate(sweep.overrides)
    ]
    told = set()
    for together in [[*one, *grid] for one in sets or [[]]]:
        for first, second in exclusive(str(path[-1]) for _, path in together):
            (name, path), (other, of_other) = together[first], together[second]
            if (name, other) in told:  # two of the grid clash beside every set
                continue
            told.add((name, other))
            place = document.key_span(*of_other)
            yield Diagnostic.of(
                "SPEC108",
                document.key_span(*path),
                problem=f"`{name}` and `{other}` exclude each other",
                label=f"`{other}` is given in line {place.line}",
                help="keep one of the two",
            )


def _specs(sweep: Sweep, document: Document) -> tuple[tuple[Path, ...], list[Diagnostic]]:
    """The task files that the patterns stand for, in the written order, each once."""
    specs, findings = dict[Path, None](), list[Diagnostic]()
    for i, pattern in enumerate(sweep.specs):
        home = document.path.parent
        matched = glob(pattern, root_dir=home, recursive=True) if has_magic(pattern) else [pattern]
        paths = [Path(os.path.normpath(home / name)) for name in matched]
        files = [path for path in paths if path.is_file()]
        specs |= dict.fromkeys(sorted(files))
        if not files:
            findings.append(
                Diagnostic.of(
                    "SPEC103",
                    document.span("specs", i),
                    key=f"specs[{i}]",
                    problem="matches no file" if has_magic(pattern) else "names no file",
                    help="paths are relative to the sweep file",
                )
            )
    return tuple(specs), findings
