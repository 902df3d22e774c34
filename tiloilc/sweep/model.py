"""The sweep file as typed, frozen models: which specs, with which settings, on which seeds."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType, NoneType
from typing import Annotated, Any, Union, get_args

from pydantic import AfterValidator, Field, create_model
from pydantic.fields import FieldInfo

from tiloilc.spec.base import Model, Whole
from tiloilc.spec.laid import DEMO_FIELDS, ORIGINS
from tiloilc.spec.problems import Form
from tiloilc.spec.schema import form_schema
from tiloilc.spec.settings import Settings, Steps

OWN = ("seeds", "first_seed")
"""Settings that say which agents there are, not what they are: they hold for a whole sweep."""


def _value(field: FieldInfo, needed: bool = False) -> object:
    """The type of a setting, with its limits; if it is `needed`, without nothing as a value."""
    kind: object = field.annotation
    if needed:
        kind = Union[tuple(option for option in get_args(kind) if option is not NoneType)]  # noqa: UP007
    return Annotated[kind, Field(examples=field.examples), *field.metadata]


def _partial(name: str, about: str, kind: Callable[[object], object]) -> type[Model]:
    """A model with the settings of training and of demonstrations, none of which must be given."""
    fields: dict[str, Any] = {}
    for key, field in {**Settings.model_fields, **DEMO_FIELDS}.items():
        if key not in OWN:
            free = Field(
                default=None,
                description=field.description,
                json_schema_extra=lambda about: about.pop("default"),  # the task file's own
            )
            fields[key] = (kind(_value(field, needed=key in ORIGINS)), free)
    return create_model(name, __base__=Model, __doc__=about, **fields)


Changes = _partial("Changes", "Settings that differ from the task file's.", lambda value: value)
Grid = _partial(
    "Grid",
    "Values that settings take in turn.",
    lambda value: Annotated[list[value], Field(min_length=1)],  # type: ignore[valid-type]
)


Algorithm = _value(Settings.model_fields["algorithm"])


RECORD_ENDINGS = (".jsonl.gz", ".jsonl")
"""How a file of records ends; what ends otherwise is a folder of them."""

_PLACES = re.compile(r"\{(?:name|algorithm)\}")


def record_pattern(text: str) -> str:
    """Where records are to be kept. Raises ValueError where braces would be taken literally."""
    filled = _PLACES.sub("", text) if text.endswith(RECORD_ENDINGS) else text
    if "{" not in filled and "}" not in filled:
        return text
    if filled == text and _PLACES.search(text):
        raise ValueError("must end in .jsonl or .jsonl.gz where it has {name} or {algorithm}")
    raise ValueError("may have {name} and {algorithm}, and nothing else in braces")


class Sweep(Model):
    """Specs × algorithms × sets of settings × seeds."""

    description: str = Field(default="", description="what the sweep is for")
    specs: list[Annotated[str, Field(min_length=1)]] = Field(
        min_length=1, description="task files, or patterns like `specs/grid_*.yaml`"
    )
    algorithms: list[Algorithm] | None = Field(  # type: ignore[valid-type]
        default=None, min_length=1, description="each with every spec; else the spec's own"
    )
    steps: Steps | None = Field(default=None, description="instead of the specs' own")
    seeds: Annotated[int, *Settings.model_fields["seeds"].metadata] | None = Field(
        default=None, description="instead of the specs' own"
    )
    first_seed: Annotated[int, *Settings.model_fields["first_seed"].metadata] | None = Field(
        default=None, description="instead of the specs' own"
    )
    seeds_per_job: Whole | None = Field(
        default=None, gt=0, description="seeds trained together in one program; else all"
    )
    overrides: list[Changes] = Field(  # type: ignore[valid-type]
        default_factory=list, description="sets of settings, each with every spec and algorithm"
    )
    grid: Grid | None = Field(  # type: ignore[valid-type]
        default=None, description="values of settings, every combination with every set"
    )
    records: Annotated[str, Field(min_length=1), AfterValidator(record_pattern)] | None = Field(
        default=None,
        description="a folder, or a pattern with {name}, {algorithm} that ends in .jsonl.gz",
    )


SWEEP_FILE = Form(Sweep, "a sweep file")


def sweep_schema() -> dict[str, Any]:
    """The JSON Schema of a sweep file."""
    return form_schema(SWEEP_FILE)


def given(changes: Model) -> Mapping[str, object]:
    """What a set of settings gives, as plain values."""
    return MappingProxyType(changes.model_dump(mode="json", exclude_unset=True))
