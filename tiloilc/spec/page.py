"""Every setting of a task file in one table, made from the models: `docs/settings.md`."""

from __future__ import annotations

import math
import re
import types
from collections.abc import Iterator, Sequence
from typing import Annotated, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from tiloilc.spec.base import Model
from tiloilc.spec.model import Spec
from tiloilc.spec.presets import DEFAULT, PAPER
from tiloilc.spec.settings import Settings

INTRODUCTION = """\
# Settings

Everything that a task file can say. `train:` takes what is not given from its `preset`: `default`
is what was measured to be best on the tasks that run here, `paper` is Table 5 of the paper to the
letter. Sources are places in the paper. Of `formula` and `automaton`, and of `source` and `file`,
just one is given.

Written by `tiloilc schema --format markdown`; do not edit.

| key | values | default | `paper` | meaning | source |
|---|---|---|---|---|---|
"""

_SOURCE = re.compile(r" \(((?:Algorithm|Eq\.|appendix|definition|figure|section|table)[^()]*)\)$")
"""Where a description names its place in the paper."""

_KINDS = {int: "whole number", float: "number", str: "text", bool: "`true`, `false`"}


def settings_page() -> str:
    """The page in Markdown: a row for each key, in the order of the models."""
    return INTRODUCTION + "".join(_row(*cells) for cells in _rows(Spec, ()))


def _rows(model: type[Model], path: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    for name, field in model.model_fields.items():
        inner = next(
            (m for m in _models(field.annotation) if m.__name__ != "PythonPredicate"), None
        )
        if inner is not None:
            yield from _rows(inner, (*path, name))
            continue
        meaning = str(field.description)
        source = _SOURCE.search(meaning)
        yield (
            f"`{'.'.join((*path, name))}`",
            _values(field),
            *_defaults(model, name, field),
            meaning[: source.start()] if source else meaning,
            source.group(1) if source else "",
        )


def _row(*cells: str) -> str:
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |\n"


def _models(kind: object) -> Iterator[type[Model]]:
    """The sections that a value may be."""
    if get_origin(kind) in (Union, types.UnionType, Annotated):
        for option in get_args(kind):
            yield from _models(option)
    elif isinstance(kind, type) and issubclass(kind, Model):
        yield kind


def _defaults(model: type[Model], name: str, field: FieldInfo) -> tuple[str, str]:
    """What holds where nothing is given, by both presets."""
    if model is Settings:
        return tuple(  # type: ignore[return-value]  # there are two presets
            _shown(preset[name]) if name in preset else "required" for preset in (DEFAULT, PAPER)
        )
    if field.is_required():
        return "required", ""
    default = field.get_default(call_default_factory=True)
    return ("–" if default in (None, "", {}) else _shown(default)), ""


def _shown(value: object) -> str:
    """A value as a task file would have it."""
    match value:
        case bool():
            return f"`{str(value).lower()}`"
        case int():
            return f"`{value:_}`"
        case float():
            return "`1/3`" if value == 1 / 3 else f"`{value:g}`"
        case tuple():
            return f"`[{', '.join(str(item) for item in value)}]`"
    return f"`{value}`"


def _values(field: FieldInfo) -> str:
    """What a value may be, with its limits."""
    return ", or ".join(dict.fromkeys(_alternatives(field.annotation, field.metadata)))


def _alternatives(kind: object, about: Sequence[object]) -> Iterator[str]:
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        yield from _alternatives(inner[0], [*inner[1:], *about])
    elif origin in (Union, types.UnionType):
        for option in inner:
            if option is not type(None):
                yield from _alternatives(option, about)
    elif origin is Literal:
        yield ", ".join(f"`{word}`" for word in inner)
    elif origin is tuple:
        item = next(_alternatives(inner[0], ()))
        yield f"[{item}, …]" if inner[-1] is Ellipsis else f"[{', '.join([item] * len(inner))}]"
    elif origin is dict:
        yield f"names: {' or '.join(_alternatives(inner[1], ()))}"
    elif isinstance(kind, type) and issubclass(kind, Model):
        yield " or ".join(f"`{name}:`" for name in kind.model_fields)
    else:
        words = _KINDS.get(kind, "any value") if isinstance(kind, type) else "any value"
        yield f"{words}{_interval(about, whole=kind is int)}"


def _interval(about: Sequence[object], whole: bool) -> str:
    """The limits that pydantic was given, ` in [0, 1)`; whole numbers by the last of each side."""
    found: dict[str, float] = {}
    for part in about:
        for limit in part.metadata if isinstance(part, FieldInfo) else [part]:
            names = [name for name in ("gt", "ge", "lt", "le") if hasattr(limit, name)]
            found |= {name: getattr(limit, name) for name in names}
    if not found:
        return ""
    if whole:
        found = {
            "ge": found.get("ge", found.get("gt", 0) + 1),
            "le": found.get("le", found.get("lt", 0) - 1),
        }
    low = f"[{_number(found['ge'])}" if "ge" in found else f"({_number(found.get('gt', -math.inf))}"
    high = f"{_number(found['le'])}]" if "le" in found else f"{_number(found.get('lt', math.inf))})"
    return f" in {low}, {high}"


def _number(value: float) -> str:
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return f"{int(value):_}" if value == int(value) else f"{value:g}"
