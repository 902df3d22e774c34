"""The plan as canonical JSON: the same plan is the same bytes, and only such bytes are read."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence

from pydantic import ValidationError

from tiloilc.automaton.ldba import Cube, Edge, Ldba
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.plan.model import SCHEMA_VERSION, Plan, Predicate, Stages
from tiloilc.plan.options import is_partition, options
from tiloilc.spec.base import Model
from tiloilc.spec.model import Demonstrations, Environment, Evaluate
from tiloilc.spec.settings import Settings

__all__ = ["automaton_json", "canonical", "digest", "from_json", "ldba_from_json", "to_json"]

Json = None | bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"]

LATER: Mapping[str, object] = {"inference_growth": 1.0}
"""Settings of training that came after plans were written, and what they were before."""


class _Strict(Model, strict=True):
    """Types as they are: no text that looks like a number."""


class _Edge(_Strict):
    source: int
    target: int
    guard: str
    cubes: list[list[int]]


class _Option(_Strict):
    state: int
    guard: str
    cubes: list[list[int]]
    targets: list[int]


class _Automaton(_Strict):
    propositions: list[str]
    states: list[str]
    initial: int
    accepting: list[int]
    accepting_edges: list[int]
    sink: int | None
    edges: list[_Edge]
    jumps: list[list[int]]
    options: list[_Option]


class _Stages(_Strict):
    index: list[int]
    length: list[int]
    distance: list[int]
    positive: list[list[int]]
    negative: list[list[int]]


class _Predicate(_Strict):
    name: str
    text: str
    python: str


class _File(Model):
    """The whole file; sections of the task file are read as there."""

    schema_version: int
    version: str
    name: str
    description: str
    root: str
    environment: Environment
    fields: dict[str, list[int]]
    predicates: list[_Predicate]
    formula: str
    automaton: _Automaton
    stages: _Stages
    demonstrations: Demonstrations
    train: dict[str, object]
    evaluate: Evaluate
    digests: dict[str, str]


def to_json(plan: Plan) -> str:
    """`plan` as canonical JSON text: sorted keys, flat lists on one line, ended by a newline."""
    about: dict[str, Json] = {
        "schema_version": plan.schema_version,
        "version": plan.version,
        "name": plan.name,
        "description": plan.description,
        "root": plan.root,
        "environment": plan.environment.model_dump(mode="json"),
        "fields": {name: list(span) for name, span in plan.fields.items()},
        "predicates": [dataclasses.asdict(predicate) for predicate in plan.predicates],
        "formula": plan.formula,
        "automaton": automaton_json(plan.ldba),
        "stages": dataclasses.asdict(plan.stages),
        "demonstrations": _demonstrations(plan.demonstrations),
        "train": _train(plan.train),
        "evaluate": plan.evaluate.model_dump(mode="json"),
        "digests": dict(plan.digests),
    }
    return canonical(about) + "\n"


def _demonstrations(wanted: Demonstrations) -> Json:
    """A key that came later is written where it is given only: plans of before stay the same."""
    return wanted.model_dump(mode="json", exclude={"minari"} if wanted.minari is None else None)


def _train(settings: Settings) -> Json:
    """Likewise settings that came later: written where they change something."""
    dumped = settings.model_dump(mode="json")
    return {name: value for name, value in dumped.items() if LATER.get(name) != value}


def digest(plan: Plan) -> str:
    """The sha256 of the plan's canonical text, wherever its task file stands."""
    text = to_json(dataclasses.replace(plan, root=""))
    return hashlib.sha256(text.encode()).hexdigest()


def from_json(text: str, file: str = "plan.json") -> Plan:
    """The plan behind `text`; `file` names it in messages.

    Raises CompileError PLAN407 for anything that is not a whole and consistent plan.
    """
    try:
        data = json.loads(text, parse_constant=_no_number)
    except json.JSONDecodeError as error:
        place = Span.at(file, error.lineno, error.colno)
        raise _unreadable(f"not JSON ({_decapitalised(error.msg)})", file, place) from None
    except ValueError as error:
        raise _unreadable(f"not JSON ({error})", file) from None
    except RecursionError:
        raise _unreadable("nested too deeply", file) from None
    given = data.get("schema_version") if isinstance(data, dict) else None
    if given != SCHEMA_VERSION:
        problem = "no `schema_version`" if given is None else f"its schema version is {given}"
        raise _unreadable(f"{problem}, this tiloilc reads {SCHEMA_VERSION}", file)
    try:
        read = _File.model_validate(data)
        train = _settings(read.train)
    except ValidationError as error:
        raise _unreadable(_first(error), file) from None
    ldba = _ldba(read.automaton, file)
    return Plan(
        name=read.name,
        description=read.description,
        environment=read.environment,
        fields={name: _pair(span, f"fields.{name}", file) for name, span in read.fields.items()},
        predicates=tuple(Predicate(p.name, p.text, p.python) for p in read.predicates),
        formula=read.formula,
        ldba=ldba,
        stages=_stages(read.stages, ldba, file),
        demonstrations=read.demonstrations,
        train=train,
        evaluate=read.evaluate,
        digests=dict(read.digests),
        version=read.version,
        schema_version=read.schema_version,
        root=read.root,
    )


def automaton_json(ldba: Ldba) -> dict[str, Json]:
    """`ldba` with its jumps, each guard as text and as cubes [mask, value], and the options."""
    names = ldba.propositions
    return {
        "propositions": list(names),
        "states": list(ldba.names),
        "initial": ldba.initial,
        "accepting": sorted(ldba.accepting),
        "accepting_edges": sorted(ldba.accepting_edges),
        "sink": ldba.sink,
        "edges": [
            {"source": e.source, "target": e.target, **_guard(e.guard, names)} for e in ldba.edges
        ],
        "jumps": [list(jump) for jump in ldba.jumps],
        "options": [
            {"state": o.state, "targets": list(o.targets), **_guard(o.guard, names)}
            for o in options(ldba)
        ],
    }


def ldba_from_json(data: Mapping[str, Json], file: str = "plan.json") -> Ldba:
    """The automaton behind `automaton_json`'s data. Raises CompileError PLAN407."""
    try:
        return _ldba(_Automaton.model_validate(data), file)
    except ValidationError as error:
        raise _unreadable(_first(error), file) from None


def canonical(value: Json, indent: str = "") -> str:
    """JSON with sorted keys, two spaces a level, and lists of plain values on one line."""
    deeper = indent + "  "
    if isinstance(value, Mapping):
        if not value:
            return "{}"
        items = [
            f"{deeper}{_scalar(key)}: {canonical(value[key], deeper)}" for key in sorted(value)
        ]
        return "{\n" + ",\n".join(items) + f"\n{indent}}}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        if not any(isinstance(item, Mapping) for item in value):
            return json.dumps(value, ensure_ascii=False, allow_nan=False)
        items = [deeper + canonical(item, deeper) for item in value]
        return "[\n" + ",\n".join(items) + f"\n{indent}]"
    return _scalar(value)


def _scalar(value: Json) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _guard(cubes: Sequence[Cube], names: Sequence[str]) -> dict[str, Json]:
    from tiloilc.automaton import guard_text

    return {
        "guard": guard_text(tuple(cubes), tuple(names)),
        "cubes": [[cube.mask, cube.value] for cube in cubes],
    }


def _settings(given: Mapping[str, object]) -> Settings:
    given = {**LATER, **given}
    missing = sorted(set(Settings.model_fields) - set(given))
    if missing:
        raise ValidationError.from_exception_data(
            "plan", [{"type": "missing", "loc": ("train", missing[0]), "input": given}]
        )
    return Settings.model_validate(given)


def _ldba(read: _Automaton, file: str) -> Ldba:
    n, full = len(read.states), (1 << len(read.propositions)) - 1
    numbers = [read.initial, *read.accepting, *(b for jump in read.jumps for b in jump)]
    numbers += [b for edge in read.edges for b in (edge.source, edge.target)]
    numbers += [] if read.sink is None else [read.sink]
    if not all(0 <= b < n for b in numbers):
        raise _unreadable(f"the automaton names a state that is not among its {n}", file)
    if not all(0 <= edge < len(read.edges) for edge in read.accepting_edges):
        raise _unreadable("the automaton marks an edge that it does not have", file)
    if len(set(read.propositions)) < len(read.propositions):
        raise _unreadable("the automaton names a proposition twice", file)
    cubes = [cube for edge in read.edges for cube in edge.cubes]
    if any(len(c) != 2 or c[0] & ~full or c[1] & ~c[0] or min(c) < 0 for c in cubes):
        raise _unreadable("a guard of the automaton is no set of letters", file)
    ldba = Ldba(
        propositions=tuple(read.propositions),
        names=tuple(read.states),
        accepting=frozenset(read.accepting),
        sink=read.sink,
        edges=tuple(
            Edge(e.source, e.target, tuple(Cube(*cube) for cube in e.cubes)) for e in read.edges
        ),
        jumps=tuple(_pair(jump, "automaton.jumps", file) for jump in read.jumps),
        accepting_edges=frozenset(read.accepting_edges),
        initial=read.initial,
    )
    for b in ldba.states:
        if not is_partition([edge.guard for edge in ldba.outgoing[b]]):
            raise _unreadable(f"the edges of automaton state {b} do not partition letters", file)
    if automaton_json(ldba) != read.model_dump(mode="json"):
        raise _unreadable("the automaton's guards or options contradict each other", file)
    return ldba


def _stages(read: _Stages, ldba: Ldba, file: str) -> Stages:
    n = len(ldba.names)
    lengths = {len(column) for column in read.model_dump().values()}
    buffers = [b for row in (*read.positive, *read.negative) for b in row]
    if lengths != {n} or not all(0 <= b <= n for b in buffers) or min(read.length) < 1:
        raise _unreadable("the stages do not fit the automaton", file)
    return Stages(
        tuple(read.index),
        tuple(read.length),
        tuple(read.distance),
        tuple(map(tuple, read.positive)),
        tuple(map(tuple, read.negative)),
    )


def _no_number(name: str) -> float:
    raise ValueError(f"{name} is no number")


def _pair(values: Sequence[int], key: str, file: str) -> tuple[int, int]:
    if len(values) != 2:
        raise _unreadable(f"`{key}`: two numbers are needed", file)
    return values[0], values[1]


def _first(error: ValidationError) -> str:
    """The first of pydantic's findings in one line."""
    found = error.errors(include_url=False, include_context=False, include_input=False)[0]
    key = ".".join(str(part) for part in found["loc"])
    return f"`{key}`: {_decapitalised(found['msg'])}" if key else _decapitalised(found["msg"])


def _decapitalised(text: str) -> str:
    return text[:1].lower() + text[1:]


def _unreadable(problem: str, file: str, place: Span | None = None) -> CompileError:
    return CompileError(Diagnostic.of("PLAN407", place or Span.at(file), problem=problem))
