"""Every setting of training, resolved: the presets and what may override them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from tiloilc.spec.model import Model, Number, Whole


def _entropy(value: object) -> object:
    return value if value == "tuned" else _as_number(value)


def _as_number(value: object) -> object:
    return float(value) if isinstance(value, int | float | str) else value


class Settings(Model):
    """All settings of a training run (paper, table 5 and appendix H.2). Widths are hidden units."""

    algorithm: Literal["tiloil", "cloning"] = Field(description="what is learned")
    preset: Literal["default", "paper"] = Field(description="where unset settings come from")
    steps: Whole = Field(gt=0, description="environment steps, per seed")
    seeds: Whole = Field(gt=0, description="independent agents, trained together")
    first_seed: Whole = Field(ge=0, description="the first agent's seed; the others follow")
    beta: Number = Field(ge=0, description="weight of the discriminators in the reward (Eq. 8)")


class Train(Model):
    """The `train` section: steps, seeds, a preset, and any setting that differs from it."""

    algorithm: Literal["tiloil", "cloning"] = "tiloil"
    preset: Literal["default", "paper"] = "default"
    steps: Whole = Field(gt=0)
    seeds: Whole = Field(default=10, gt=0)
    first_seed: Whole = Field(default=0, ge=0)
    beta: Number | None = Field(default=None, ge=0)
