"""Every setting of training: what a task file may say, the presets, and the resolved whole."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from tiloilc.spec.base import Model, Number, Whole, to_number


def _entropy(value: object) -> object:
    return value if value == "tuned" else to_number(value)


Entropy = Annotated[
    Literal["tuned"] | Annotated[float, Field(ge=0, le=100)], BeforeValidator(_entropy)
]
Epsilon = Literal["free", "step"]
Share = Annotated[float, BeforeValidator(to_number), Field(ge=0, le=1)]
Positive = Annotated[float, BeforeValidator(to_number), Field(gt=0)]
Count = Annotated[int, BeforeValidator(to_number), Field(gt=0)]
Widths = Annotated[tuple[Count, ...], Field(min_length=1)]


class Settings(Model):
    """The `train` section with every setting resolved (paper, table 5 and appendix H.2).

    What is not given is taken from the preset; only `steps` must be given.
    """

    model_config = ConfigDict(json_schema_extra={"required": ["steps"]})

    algorithm: Literal["tiloil", "cloning"] = Field(description="what is learned")
    preset: Literal["default", "paper"] = Field(description="where unset settings come from")
    backbone: Literal["auto", "sac", "tabular"] = Field(
        description="auto: tabular Q-learning on finite environments, SAC elsewhere"
    )
    steps: Count = Field(description="environment steps, per seed")
    seeds: Count = Field(le=1000, description="independent agents, trained together")
    first_seed: Whole = Field(ge=0, description="the first agent's seed; the others count up")
    checkpoint_every: Count = Field(description="environment steps between two checkpoints")

    beta: Number = Field(ge=0, description="weight of the discriminators in the reward (Eq. 8)")
    segment: bool = Field(description="cut episodes at accepting states (section 3.1)")
    stages: bool = Field(description="a reward for each stage (section 3.2), else one for all")
    discriminator: Literal["separate", "shared"] = Field(
        description="one network a stage, or one that is told the stage (appendix F.2)"
    )
    accepting_target: Literal["constant", "live", "segment"] = Field(
        description="the value target at accepting states: Eq. 4; one that rewards staying "
        "accepting; or that of the state whose reading it shares, which begins the next segment"
    )
    epsilon: Epsilon = Field(
        description="an ε-jump reads the letter and takes no time; or is a step of its own, in "
        "which the environment stands still and no letter is read (definition 2.3)"
    )
    exact_entry: bool = Field(description="entering acceptance or a sink has its exact value")
    end_on_sink: bool = Field(description="stop an episode once acceptance is out of reach")
    sink_reward: Number = Field(description="reward of each step in a sink")
    gamma: Number = Field(gt=0, lt=1, description="discount")

    demo_fraction: Share = Field(
        description="share of demonstration states in a discriminator's positive batch"
    )
    demo_replay: Share = Field(description="share of demonstration steps in a replay batch")
    warm_start: Literal["none", "bc"] = Field(description="clone the demonstrations first")
    warm_start_steps: Whole = Field(
        ge=0, description="environment steps over which the cloning loss fades"
    )

    batch_size: Count = Field(description="transitions in an update")
    buffer_size: Count = Field(description="transitions kept, per seed")
    stage_buffer_size: Count = Field(description="states kept for each stage, per seed")
    learning_starts: Whole = Field(ge=0, description="random environment steps before learning")
    updates_per_step: Positive = Field(description="updates for each environment step")
    tau: Share = Field(description="step of the target network at each update")
    actor_rate: Positive = Field(description="Adam's step size for the actor")
    critic_rate: Positive = Field(description="Adam's step size for the critics")
    discriminator_rate: Positive = Field(description="Adam's step size for the discriminators")
    actor_hidden: Widths = Field(description="units of the actor's hidden layers")
    critic_hidden: Widths = Field(description="units of the critics' hidden layers")
    discriminator_hidden: Widths = Field(description="units of the discriminators' hidden layers")
    discriminator_batch: Count = Field(description="positive and as many negative states")
    layer_norm: bool = Field(description="layer normalisation in the critics")
    entropy: Entropy = Field(description="the temperature α, or `tuned` to the target entropy")
    target_entropy: Number = Field(description="wanted entropy for each action dimension, in nats")

    learning_rate: Positive = Field(description="step size of tabular Q-learning", le=1)
    exploration: Share = Field(description="share of random actions in tabular Q-learning")
    optimistic: Literal["auto"] | bool = Field(
        description="tabular Q-learning begins with the greatest value; auto: if there are no "
        "demonstrations to follow"
    )
    relabel: bool = Field(
        description="tabular Q-learning learns each step for every live automaton state"
    )

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, given: object) -> object:
        if not isinstance(given, Mapping):
            return given
        preset = PRESETS.get(str(given.get("preset")), DEFAULT)
        return {**preset, **given}

    def overrides(self) -> dict[str, object]:
        """The settings that differ from their preset's."""
        preset = PRESETS[self.preset]
        dumped = self.model_dump()
        return {k: v for k, v in dumped.items() if k in preset and preset[k] != v}

    def override(self, changes: Mapping[str, object]) -> Settings:
        """These settings with `changes`; another preset replaces what was not set apart from it.

        Raises pydantic.ValidationError for names and values that no setting takes.
        """
        given = {"steps": self.steps, "preset": self.preset, **self.overrides()}
        return Settings.model_validate({**given, **changes})


PAPER: MappingProxyType[str, object] = MappingProxyType(
    {
        "algorithm": "tiloil",
        "preset": "paper",
        "backbone": "auto",
        "seeds": 10,
        "first_seed": 0,
        "checkpoint_every": 10_000,
        "beta": 1 / 3,
        "segment": True,
        "stages": True,
        "discriminator": "separate",
        "accepting_target": "constant",
        "epsilon": "free",
        "exact_entry": False,
        "end_on_sink": False,
        "sink_reward": -1.0,
        "gamma": 0.99,
        "demo_fraction": 0.5,
        "demo_replay": 0.0,
        "warm_start": "none",
        "warm_start_steps": 0,
        "batch_size": 64,
        "buffer_size": 1_000_000,
        "stage_buffer_size": 100_000,
        "learning_starts": 2_000,
        "updates_per_step": 1.0,
        "tau": 1e-4,
        "actor_rate": 3e-4,
        "critic_rate": 3e-4,
        "discriminator_rate": 3e-4,
        "actor_hidden": (256, 256, 256),
        "critic_hidden": (256, 256),
        "discriminator_hidden": (32,),
        "discriminator_batch": 64,
        "layer_norm": False,
        "entropy": 0.2,
        "target_entropy": -1.0,
        "learning_rate": 3e-4,
        "exploration": 0.2,
        "optimistic": False,
        "relabel": False,
    }
)
"""Table 5 to the letter; where the paper is silent, what algorithms of its family do."""

DEFAULT: MappingProxyType[str, object] = MappingProxyType(
    {
        **PAPER,
        "preset": "default",
        "accepting_target": "segment",
        "exact_entry": True,
        "end_on_sink": True,
        "gamma": 0.95,
        "demo_replay": 0.25,
        "warm_start": "bc",
        "warm_start_steps": 2_000,
        "tau": 5e-3,
        "actor_rate": 1e-3,
        "critic_rate": 1e-3,
        "actor_hidden": (64, 64),
        "critic_hidden": (64, 64),
        "layer_norm": True,
        "entropy": "tuned",
        "target_entropy": -3.0,
        "learning_rate": 1.0,
        "optimistic": "auto",
        "relabel": True,
    }
)
"""What was measured to be best on the tasks of the paper that run on numpy."""

PRESETS = MappingProxyType({"default": DEFAULT, "paper": PAPER})


Train = Settings
"""The `train` section of a task file."""
