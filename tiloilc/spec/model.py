"""The task file as typed, frozen models (contract: every key, its type, default and meaning)."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from tiloilc.spec.base import Model, Whole, to_number
from tiloilc.spec.settings import Train

MAX_NAME = 100
"""Characters in the name of a task: what is made of it, with more added, must name a folder."""

NAME_SIGNS = "ASCII letters, digits, `_`, `-` and `.`, the first a letter or digit"
"""What such a name is made of, in words."""


class Environment(Model):
    """Which environment, how it is made, how long an episode is."""

    id: str = Field(
        min_length=1, description="Gymnasium id; `module:Id-v0` imports the module first"
    )
    kwargs: dict[str, Any] = Field(default_factory=dict, description="arguments of the environment")
    horizon: Whole = Field(gt=0, le=1_000_000, description="environment steps in an episode")


class Demonstrations(Model):
    """Where demonstrations come from and what of them is used."""

    source: Literal["expert"] | None = Field(default=None, description="the task's scripted expert")
    file: str | None = Field(default=None, description="an .npz of demonstrations")
    minari: str | None = Field(
        default=None, min_length=1, description="the id of a Minari dataset on this machine"
    )
    count: Whole = Field(
        default=5, ge=0, le=100_000, description="how many are used (appendix G.2)"
    )
    max_visits: Whole | None = Field(
        default=None,
        gt=0,
        le=1_000_000,
        description="cut each after that many accepting visits (section 4)",
    )
    max_steps: Whole | None = Field(
        default=None, gt=0, le=1_000_000, description="cut each after that many steps (table 4)"
    )
    actions: Literal["none", "recorded", "inferred"] = Field(
        default="none", description="what may enter the replay beside the states"
    )

    @property
    def kind(self) -> Literal["source", "file", "minari"]:
        """The key that says where they come from."""
        if self.file is not None:
            return "file"
        return "source" if self.minari is None else "minari"


class Evaluate(Model):
    """How a policy is judged."""

    episodes: Whole = Field(default=20, gt=0, le=10_000, description="episodes per seed")
    every: Whole | None = Field(
        default=None,
        gt=0,
        le=1_000_000_000,
        description="environment steps between two evaluations; else there are 20",
    )


class PythonPredicate(Model):
    """A label function for what the predicate language cannot say."""

    python: str = Field(description="file.py:function, relative to the task file")


def _field_range(value: object) -> object:
    """An index, or [start, stop), as whole numbers."""
    wrong = ValueError("must be an index like 4, or [start, stop] with 0 <= start < stop")
    if not isinstance(value, list | tuple):
        index = to_number(value)
        if not isinstance(index, int) or index < 0:
            raise wrong
        return index
    ends = [to_number(end) for end in value]
    match ends:
        case [int(start), int(stop)] if 0 <= start < stop:
            return start, stop
    raise wrong


FieldRange = Annotated[int | tuple[int, int], BeforeValidator(_field_range)]
FieldName = Annotated[str, Field(pattern=r"^[^\W\d]\w*$")]


def _predicate_kind(value: object) -> str:
    return "a mapping" if isinstance(value, dict | PythonPredicate) else "a text"


PredicateText = Annotated[
    Annotated[str, Field(min_length=1), Tag("a text")]
    | Annotated[PythonPredicate, Tag("a mapping")],
    Discriminator(_predicate_kind),
]


class Spec(Model):
    """One task: an environment, what is true in its states, a formula, and how to learn it."""

    name: str = Field(
        max_length=MAX_NAME,
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$",
        description="names the folders of the task",
    )
    description: str = Field(default="", description="the task in a sentence or two")
    environment: Environment = Field(description="where the agent acts")
    observation: dict[FieldName, FieldRange] = Field(
        default_factory=dict,
        description="names for components of the observation: an index, or [start, stop]",
    )
    propositions: dict[str, PredicateText] = Field(
        min_length=1,
        description="what is true in a state, each a predicate; the order is that of the bits",
    )
    formula: str | None = Field(
        default=None, min_length=1, description="linear temporal logic over the propositions"
    )
    automaton: str | None = Field(
        default=None, min_length=1, description="a HOA file instead of a formula"
    )
    demonstrations: Demonstrations | None = Field(
        default=None, description="examples to imitate, or none"
    )
    train: Train = Field(description="how the agent learns")
    evaluate: Evaluate = Field(default_factory=Evaluate, description="how a policy is judged")

    @property
    def fields(self) -> dict[str, tuple[int, int]]:
        """The observation's components that the task file names, as [start, stop)."""
        return {
            name: (where, where + 1) if isinstance(where, int) else where
            for name, where in self.observation.items()
        }
