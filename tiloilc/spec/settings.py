"""Every setting of training: what a task file may say, and the resolved whole."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from tiloilc.seeds import LAST_SEED, MOST_AGENTS
from tiloilc.spec.base import Model, Number, Whole, to_number
from tiloilc.spec.presets import preset_of, what_it_is


def _number_or(word: str) -> BeforeValidator:
    return BeforeValidator(lambda value: value if value == word else to_number(value))


Entropy = Annotated[Literal["tuned"] | Annotated[float, Field(ge=0, le=100)], _number_or("tuned")]
Exploration = Annotated[Literal["auto"] | Annotated[float, Field(ge=0, le=1)], _number_or("auto")]
Epsilon = Literal["free", "step"]
Share = Annotated[float, BeforeValidator(to_number), Field(ge=0, le=1)]
Rate = Annotated[float, BeforeValidator(to_number), Field(gt=0, le=1)]
Steps = Annotated[int, BeforeValidator(to_number), Field(gt=0, le=1_000_000_000)]
Delay = Annotated[int, BeforeValidator(to_number), Field(ge=0, le=1_000_000_000)]
Rows = Annotated[int, BeforeValidator(to_number), Field(gt=0, le=100_000_000)]
Batch = Annotated[int, BeforeValidator(to_number), Field(gt=0, le=65_536)]
Width = Annotated[int, BeforeValidator(to_number), Field(gt=0, le=16_384)]
Widths = Annotated[tuple[Width, ...], Field(min_length=1, max_length=16)]
"""Limits are far beyond what learns: a slip of the finger is a finding, not a full memory."""


ALGORITHMS = ("tiloil", "cloning", "lcer", "cycler", "drl2", "gail", "pwil", "sqil")
"""What `algorithm` may be without any package that adds more."""

ALGORITHM_GROUP = "tiloilc.algorithms"
"""The entry points by which packages add algorithms."""


class Settings(Model):
    """The `train` section with every setting resolved (paper, table 5 and appendix H.2).

    What is not given is taken from the preset; only `steps` must be given.
    """

    model_config = ConfigDict(json_schema_extra={"required": ["steps"]})

    algorithm: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$",
        examples=list(ALGORITHMS),
        description="`tiloil` (Algorithm 1); `cloning`, which stops where learning would begin; a "
        "baseline that learns from the formula (`lcer`, `cycler`, `drl2`) or from demonstrations "
        "(`gail`, `pwil`, `sqil`); or what an installed package adds",
    )
    preset: Literal["default", "paper"] = Field(description="where unset settings come from")
    backbone: Literal["auto", "sac", "tabular"] = Field(
        description="`auto`: tabular on finite environments, SAC elsewhere (appendix H.2)"
    )
    steps: Steps = Field(description="environment steps, per seed")
    seeds: Whole = Field(gt=0, le=MOST_AGENTS, description="independent agents, trained together")
    copies: Whole = Field(
        gt=0,
        le=4096,
        description="environments that each agent steps side by side; a step of all counts as many",
    )
    first_seed: Whole = Field(
        ge=0, le=LAST_SEED, description="the first agent's seed; the others count up"
    )
    checkpoint_every: Steps = Field(description="environment steps between two checkpoints")

    beta: Number = Field(
        ge=0, description="weight of the discriminators in the reward, below 1/2 (Eq. 8, table 1)"
    )
    segment: bool = Field(description="cut episodes at accepting states (section 3.1, figure 4)")
    stages: bool = Field(
        description="a reward for each stage, else R = tanh f with one f (section 3.2, figure 4)"
    )
    discriminator: Literal["separate", "shared"] = Field(
        description="a network for each stage, or one that is told the stage; on tables there is "
        "no difference (appendix F.2)"
    )
    accepting_target: Literal["constant", "live", "segment"] = Field(
        description="the value target at accepting states: 1/(1−γ); one that rewards staying "
        "accepting; or that of the state whose reading it shares, which begins the next segment "
        "(Eq. 4)"
    )
    epsilon: Epsilon = Field(
        description="an ε-jump reads the letter and takes no time; or is a step of its own, in "
        "which the environment stands still and no letter is read (definition 2.3)"
    )
    exact_entry: bool = Field(
        description="what enters acceptance or a sink has its exact value in targets (Eq. 4)"
    )
    end_on_sink: bool = Field(description="stop an episode once acceptance is out of reach")
    sink_reward: Number = Field(ge=-1_000_000, le=0, description="reward of each step in a sink")
    gamma: Number = Field(gt=0, le=0.99999, description="discount γ (Eq. 4, table 5)")
    gamma_between: Number = Field(
        gt=0,
        le=0.99999,
        description="discount between accepting visits, where eventual discounting has 1: of "
        "`lcer`, `cycler` and `drl2`",
    )
    prior_count: Annotated[Number, Field(gt=0, le=1e12)] = Field(
        description="how many steps the optimistic prior over an automaton state's edges is worth: "
        "of `drl2`"
    )

    demo_fraction: Share = Field(
        description="share of demonstration states in a discriminator's positive batch "
        "(Algorithm 1, line 17)"
    )
    demo_replay: Share = Field(
        description="share of demonstration steps in a replay batch; on tables, whether "
        "demonstrated values are a floor"
    )
    warm_start: Literal["none", "bc"] = Field(description="clone the demonstrations first")
    warm_start_steps: Delay = Field(
        description="environment steps over which the cloning loss fades"
    )
    inference_growth: Number = Field(
        ge=1,
        le=1000,
        description="actions of demonstrations without any are inferred again each time that the "
        "agent's steps have grown by this factor, and cloned again during `warm_start_steps`; 1: "
        "once (BCO(α), Torabi et al. 2018)",
    )

    batch_size: Batch = Field(description="transitions in an update (table 5)")
    buffer_size: Rows = Field(description="transitions kept, per seed (table 5)")
    stage_buffer_size: Rows = Field(
        description="states kept for each stage, per seed (Algorithm 1, line 3)"
    )
    learning_starts: Delay = Field(description="random environment steps before learning (table 5)")
    updates_per_step: Annotated[Number, Field(gt=0, le=100)] = Field(
        description="updates for each environment step, whatever the number of copies"
    )
    tau: Rate = Field(description="step τ of the target network at each update (table 5)")
    actor_rate: Rate = Field(description="Adam's step size for the actor (Eq. 5, table 5)")
    critic_rate: Rate = Field(
        description="Adam's step size for the critics and the temperature (Eq. 3, table 5)"
    )
    final_rate: Share = Field(
        description="share of the actor's and the critics' step sizes that is left at the last "
        "step; they fall linearly"
    )
    discriminator_rate: Rate = Field(
        description="Adam's step size for the discriminators (Algorithm 1, line 19; table 5)"
    )
    actor_hidden: Widths = Field(description="units of the actor's hidden layers (appendix H.2)")
    critic_hidden: Widths = Field(description="units of the critics' hidden layers (appendix H.2)")
    discriminator_hidden: Widths = Field(
        description="units of the discriminators' hidden layers (appendix H.2)"
    )
    discriminator_batch: Batch = Field(
        description="positive and as many negative states (Algorithm 1, lines 17 and 18)"
    )
    layer_norm: bool = Field(description="layer normalisation in the critics")
    entropy: Entropy = Field(
        description="the temperature α, fixed, or `tuned` to the target entropy; on tables 0 means "
        "plain maxima (Eq. 4, Eq. 5, table 5)"
    )
    target_entropy: Number = Field(
        ge=-100,
        le=100,
        description="wanted entropy for each action dimension, in nats; on tables a negative one "
        "means α = 0",
    )

    device: Literal["auto", "cpu", "cuda"] = Field(
        description="where networks learn; `auto`: on the GPU, if there is one that torch can use"
    )
    compile: Literal["auto", "never", "always"] = Field(
        description="compile the update, where there is a C++ compiler; `auto`: for 25,000 updates "
        "or more, so that the minute it takes pays"
    )

    learning_rate: Rate = Field(description="step size of tabular Q-learning (table 5)")
    exploration: Exploration = Field(
        description="share of random actions while learning; `auto`: a fifth on tables, none in SAC"
    )
    optimistic: Literal["auto"] | bool = Field(
        description="tabular Q-learning begins with the greatest value; `auto`: if there are no "
        "demonstrations to follow"
    )
    relabel: bool = Field(
        description="learn each step for live automaton states that it was not made in as well: "
        "for all of them on tables, for one drawn at random in half of a batch elsewhere"
    )

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, given: object) -> object:
        if not isinstance(given, Mapping):
            return given
        preset, algorithm = str(given.get("preset")), str(given.get("algorithm"))
        return {**preset_of(preset, algorithm), **given}

    @property
    def steps_taken(self) -> int:
        """Environment steps that a run takes: cloning ends where learning would begin."""
        return self.learning_starts if self.algorithm == "cloning" else self.steps

    def overrides(self) -> dict[str, object]:
        """The settings that differ from their preset's."""
        preset = preset_of(self.preset, self.algorithm)
        dumped = self.model_dump()
        return {k: v for k, v in dumped.items() if k in preset and preset[k] != v}

    def override(self, changes: Mapping[str, object]) -> Settings:
        """These settings with `changes`; another preset replaces what was not set apart from it.

        Another algorithm is what it is: what was set of that for this one does not go along. Raises
        pydantic.ValidationError for names and values that no setting takes.
        """
        given = {"steps": self.steps, "preset": self.preset, **self.overrides()}
        if (algorithm := changes.get("algorithm", self.algorithm)) != self.algorithm:
            made = what_it_is(self.algorithm) | what_it_is(str(algorithm))
            given = {name: value for name, value in given.items() if name not in made}
        return Settings.model_validate({**given, **changes})


Train = Settings
"""The `train` section of a task file."""
