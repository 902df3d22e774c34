"""The task file as typed, frozen models (contract: every key, its type, default and meaning)."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


class Model(BaseModel):
    """Frozen, closed: an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def _number(value: object) -> object:
    """Numbers as people write them: `1/3`, `60_000`, `1e6`."""
    if isinstance(value, str):
        text = value.replace("_", "").strip()
        try:
            return float(Fraction(text)) if "/" in text else float(text)
        except (ValueError, ZeroDivisionError):
            return value
    return value


def _whole(value: object) -> object:
    number = _number(value)
    return int(number) if isinstance(number, float) and number.is_integer() else number


Number = Annotated[float, BeforeValidator(_number)]
Whole = Annotated[int, BeforeValidator(_whole)]


class Environment(Model):
    """Which environment, how it is made, how long an episode is."""

    id: str = Field(description="Gymnasium id; `module:Id-v0` imports the module first")
    kwargs: dict[str, Any] = Field(default_factory=dict, description="arguments of the environment")
    horizon: Whole = Field(gt=0, description="environment steps in an episode")


class Demonstrations(Model):
    """Where demonstrations come from and what of them is used."""

    source: Literal["expert"] | None = Field(default=None, description="the task's scripted expert")
    file: str | None = Field(default=None, description="an .npz of demonstrations")
    count: Whole = Field(default=5, ge=0, description="how many are used")
    max_visits: Whole | None = Field(
        default=None, gt=0, description="cut each after that many accepting visits"
    )
    actions: Literal["none", "recorded", "inferred"] = Field(
        default="none", description="what may enter the replay beside the states"
    )


class Evaluate(Model):
    """How a policy is judged."""

    episodes: Whole = Field(default=20, gt=0, description="episodes per seed")
    every: Whole | None = Field(default=None, gt=0, description="environment steps between two")


class PythonPredicate(Model):
    """A label function for what the predicate language cannot say."""

    python: str = Field(description="file.py:function, relative to the task file")
