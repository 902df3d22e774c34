"""JSON Schema of task files and their like, with which editors complete and check them."""

from __future__ import annotations

from typing import Any

from tiloilc.spec.base import Model
from tiloilc.spec.problems import TASK_FILE, Form

DIALECT = "https://json-schema.org/draft/2020-12/schema"

_NUMBER_TEXT = {
    "integer": r"^\s*[-+]?[0-9][0-9_]*(\.[0-9_]*)?([eE][-+]?[0-9]+)?\s*$",
    "number": r"^\s*[-+]?[0-9_]*\.?[0-9_]+\.?([eE][-+]?[0-9]+)?(\s*/\s*[0-9_]+)?\s*$",
}
"""Numbers as text, which YAML makes of `60_000` and `1/3`."""

_LIMITS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""Pydantic leaves limits under their own names where a value may also be null."""


def json_schema() -> dict[str, Any]:
    """The schema of a task file."""
    given = {"oneOf": [{"required": ["formula"]}, {"required": ["automaton"]}]}
    return {**form_schema(TASK_FILE), **given}


def form_schema(form: Form[Model]) -> dict[str, Any]:
    """The schema (draft 2020-12) of a file; numbers are also taken as people write them."""
    schema = _widened(form.model.model_json_schema())
    assert isinstance(schema, dict)
    rest = {k: v for k, v in schema.items() if k not in ("title", "description", "$schema")}
    return {
        "$schema": DIALECT,
        "title": f"tiloilc {form.called.removeprefix('a ')}",
        "description": str(form.model.__doc__),
        **rest,
    }


def _widened(node: Any) -> Any:
    """Every number of a schema may also be a text that is one."""
    if isinstance(node, list):
        return [_widened(item) for item in node]
    if not isinstance(node, dict):
        return node
    wide = {_LIMITS.get(k, k): _widened(v) for k, v in node.items() if k != "title"}
    kind = wide.get("type")
    if not isinstance(kind, str) or kind not in _NUMBER_TEXT:
        return wide
    about = {k: wide.pop(k) for k in ("description", "default") if k in wide}
    return {**about, "anyOf": [wide, {"type": "string", "pattern": _NUMBER_TEXT[kind]}]}
