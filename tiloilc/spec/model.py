"""The task file as typed, frozen models (contract: every key, its type, default and meaning)."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from tiloilc.spec.base import Model, Whole


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
