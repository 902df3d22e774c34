"""What the model finds wrong with a task file, said with its place and without jargon."""

from __future__ import annotations

import types
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Generic, TypeVar, Union, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from tiloilc.diag import Diagnostic, Span, nearest
from tiloilc.spec.base import Model
from tiloilc.spec.model import NAME_SIGNS, Spec
from tiloilc.spec.nodes import Node, Scalar, child, entry_at, find, kind_of, shorten

Location = tuple[str | int, ...]

MAX_LISTED = 16
"""More known keys than these are not listed in a help line."""

_WANTED = {
    "int": "a whole number",
    "float": "a number",
    "finite": "a finite number",
    "string": "text",
    "bool": "true or false",
    "list": "a list",
    "tuple": "a list",
    "dict": "a mapping of keys to values",
    "model": "a mapping of keys to values",
    "none": "empty",
}
"""What is wanted, by the first word of pydantic's error type (`int_parsing`, `float_type`, …)."""

_LIMITS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}


Read = TypeVar("Read", bound=Model, covariant=True)
"""What a file is read as."""


@dataclass(frozen=True, slots=True)
class Form(Generic[Read]):
    """What a file must be like, and what such a file is called."""

    model: type[Read]
    called: str


TASK_FILE = Form(Spec, "a task file")


def model_findings(error: ValidationError, root: Node, form: Form[Model]) -> Iterator[Diagnostic]:
    """One finding for each value or key that the model refuses."""
    wrong: dict[Location, list[ErrorDetails]] = {}
    errors = error.errors(include_url=False)
    unknown = [_path(root, e["loc"]) for e in errors if e["type"] == "extra_forbidden"]
    yield from (_unknown(root, path, form) for path in unknown)
    meant = {(*path[:-1], _meant(path, form)) for path in unknown}
    for detail in errors:
        path = _path(root, detail["loc"])
        if detail["type"] == "missing":
            key = str(detail["loc"][-1])
            if (*path, key) not in meant:  # a misspelt key is one finding, not two
                yield _missing(root, path, key, form)
        elif detail["type"] == "extra_forbidden":
            continue
        elif detail["loc"][-1:] == ("[key]",):
            yield _bad_name(root, path)
        else:
            wrong.setdefault(path, []).append(detail)
    for path, details in wrong.items():
        if details[0]["type"] == "too_short" and any(p[: len(path)] == path != p for p in wrong):
            continue  # items that are refused are not counted
        yield _wrong(root, path, details)


def refusal(error: ValidationError) -> str:
    """The first thing that the model refuses in values that stand in no file."""
    detail = error.errors(include_url=False)[0]
    name, wanted = _dotted(detail["loc"][:1]), _wanted(detail)
    if detail["type"] in ("value_error", "assertion_error"):
        return f"`{name}` {_stated(detail)}"
    if detail["type"] == "too_short":
        return f"`{name}` must not be empty"
    given = shorten(str(detail["input"]), 40)
    return (
        f"`{name}` must be {wanted}, not `{given}`" if wanted else f"`{name}` cannot be `{given}`"
    )


def place_of(root: Node, path: Location) -> Span:
    """The value at `path`; where it is empty, its key; where it is absent, what should hold it."""
    entry = entry_at(root, path)
    node = find(root, path)
    if entry is not None and isinstance(node, Scalar) and not node.text.value.strip():
        return entry.key.span
    if node is not None and path:
        return node.span
    return key_place(root, path)


def key_place(root: Node, path: Location) -> Span:
    """The key of `path`, or of the nearest part of the file that holds it; else the beginning."""
    for end in range(len(path), 0, -1):
        entry = entry_at(root, path[:end])
        if entry is not None:
            return entry.key.span
    file, line, column = root.span.file, root.span.line, root.span.column
    return Span.at(file, line, column)


def known_keys(path: Location, model: type[Model]) -> Mapping[str, FieldInfo]:
    """The keys that the model knows in the mapping at `path`."""
    kinds: list[object] = [model]
    for part in path:
        kinds = [below for kind in kinds for below in _below(kind, part)]
    return {
        name: field
        for kind in kinds
        for leaf in _leaves(kind)
        if isinstance(leaf, type) and issubclass(leaf, Model)
        for name, field in leaf.model_fields.items()
    }


def _path(root: Node, location: Location) -> Location:
    """The part of a model's location that exists in the file (unions add words of their own)."""
    node, path = root, list[str | int]()
    for part in location:
        below = child(node, part)
        if below is not None:
            node = below
            path.append(part)
    return tuple(path)


def _leaves(kind: object) -> Iterator[object]:
    """The alternatives of a type, without its annotations."""
    origin = get_origin(kind)
    if origin is Annotated:
        yield from _leaves(get_args(kind)[0])
    elif origin in (Union, types.UnionType):
        for option in get_args(kind):
            yield from _leaves(option)
    else:
        yield kind


def _below(kind: object, part: str | int) -> Iterator[object]:
    """The types of what stands under `part` in a value of type `kind`."""
    for leaf in _leaves(kind):
        if isinstance(leaf, type) and issubclass(leaf, Model):
            field = leaf.model_fields.get(str(part))
            if field is not None:
                yield field.annotation
        elif get_origin(leaf) in (dict, list, tuple):
            yield get_args(leaf)[-1 if get_origin(leaf) is dict else 0]


def _dotted(path: Iterable[str | int]) -> str:
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in path).removeprefix(".")


def _missing(root: Node, path: Location, key: str, form: Form[Model]) -> Diagnostic:
    field = known_keys(path, form.model).get(key)
    meaning = f" ({field.description})" if field is not None and field.description else ""
    return Diagnostic.of(
        "SPEC102",
        key_place(root, path),
        key=_dotted((*path, key)),
        label=f"has no `{key}`" if path else "",
        help=f"add `{key}:`{meaning}",
    )


def _unknown(root: Node, path: Location, form: Form[Model]) -> Diagnostic:
    parent, guess = path[:-1], _meant(path, form)
    known = list(known_keys(parent, form.model))
    help = f"known: {', '.join(known)}" if len(known) <= MAX_LISTED else ""
    if _outermost(path, form):
        help = f"`{path[-1]}` is a key of the {form.called.removeprefix('a ')} itself"
    return Diagnostic.of(
        "SPEC101",
        key_place(root, path),
        key=_dotted(path),
        label="not a key of " + (f"`{_dotted(parent)}`" if parent else form.called),
        help=f"did you mean `{guess}`?" if guess else help,
    )


def _outermost(path: Location, form: Form[Model]) -> bool:
    """Whether a key that stands in a section is one of the whole file."""
    return len(path) > 1 and path[-1] in form.model.model_fields


def _meant(path: Location, form: Form[Model]) -> str | None:
    """The known key that an unknown one resembles, if it is not known elsewhere."""
    if _outermost(path, form):
        return None
    return nearest(str(path[-1]), known_keys(path[:-1], form.model))


def _bad_name(root: Node, path: Location) -> Diagnostic:
    problem = "is not a name that predicates can use"
    return Diagnostic.of(
        "SPEC103",
        key_place(root, path),
        key=_dotted(path),
        problem=problem,
        help="use letters, digits and underscores, and begin with a letter",
    )


def _wrong(root: Node, path: Location, details: list[ErrorDetails]) -> Diagnostic:
    """One value; if it may be several things, each of them refused it in its own words."""
    node = find(root, path)
    shown = kind_of(node) if node is not None else "absent"
    stated = [d for d in details if d["type"] in ("value_error", "assertion_error")]
    chosen = _choices(details)
    help = ""
    if stated:
        problem = _stated(stated[0])
    elif isinstance(node, Scalar) and node.plain and not node.text.value.strip():
        problem = "is empty"
    elif "too_short" in (d["type"] for d in details) or "string_too_short" in (
        d["type"] for d in details
    ):
        problem = "must not be empty"
    else:
        wanted = list(dict.fromkeys(w for d in details if (w := _wanted(d))))
        problem = f"must be {' or '.join(wanted)}, not {shown}" if wanted else f"cannot be {shown}"
        if chosen and isinstance(node, Scalar):
            guess = nearest(node.text.value, chosen)
            help = f"did you mean `{guess}`?" if guess else ""
    if problem == "is empty":
        wanted = [w for d in details if (w := _wanted(d))]
        help = f"give it {wanted[0]}" if wanted and not chosen else ""
    return Diagnostic.of(
        "SPEC103", place_of(root, path), key=_dotted(path) or "the file", problem=problem, help=help
    )


def _choices(details: Iterable[ErrorDetails]) -> list[str]:
    """The words that a value may be, if it is a choice."""
    expected = [str(_context(d).get("expected", "")) for d in details]
    words = " or ".join(e for e in expected if e).replace(" or ", ", ").split(", ")
    return [word.strip("'") for word in words if word]


def _wanted(detail: ErrorDetails) -> str:
    """What a value should have been."""
    kind, about = detail["type"], _context(detail)
    if kind in _LIMITS:
        phrase, name = _LIMITS[kind]
        limit = about[name]
        return f"{phrase} {int(limit) if limit == int(limit) else limit:,}"
    if kind == "too_long":
        return f"at most {about['max_length']} items"
    if kind == "string_too_long":
        return f"text of at most {about['max_length']} characters"
    if kind in ("literal_error", "enum"):
        words = [f"`{word}`" for word in _choices([detail])]
        return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
    if kind == "string_pattern_mismatch":
        return f"a name of {NAME_SIGNS}"
    return _WANTED.get(kind.split("_")[0], "")


def _stated(detail: ErrorDetails) -> str:
    """The message of one of our own validators."""
    return shorten(str(_context(detail).get("error", detail["msg"])), 160)


def _context(detail: ErrorDetails) -> dict[str, Any]:
    return detail.get("ctx", {})
