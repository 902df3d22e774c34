"""Where settings come from that nobody has set: the presets, and what each algorithm is."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

PAPER: MappingProxyType[str, object] = MappingProxyType(
    {
        "algorithm": "tiloil",
        "preset": "paper",
        "backbone": "auto",
        "seeds": 10,
        "copies": 1,
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
        "gamma_between": 0.9999,
        "prior_count": 1000.0,
        "demo_fraction": 0.5,
        "demo_replay": 0.0,
        "warm_start": "none",
        "warm_start_steps": 0,
        "inference_growth": 1.0,
        "batch_size": 64,
        "buffer_size": 1_000_000,
        "stage_buffer_size": 100_000,
        "learning_starts": 2_000,
        "updates_per_step": 1.0,
        "tau": 1e-4,
        "actor_rate": 3e-4,
        "critic_rate": 3e-4,
        "final_rate": 1.0,
        "discriminator_rate": 3e-4,
        "actor_hidden": (256, 256, 256),
        "critic_hidden": (256, 256),
        "discriminator_hidden": (32,),
        "discriminator_batch": 64,
        "layer_norm": False,
        "entropy": 0.2,
        "target_entropy": -1.0,
        "device": "auto",
        "compile": "auto",
        "learning_rate": 3e-4,
        "exploration": "auto",
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
        "demo_replay": 0.1,
        "warm_start": "bc",
        "warm_start_steps": 6_000,
        "tau": 5e-3,
        "actor_rate": 1e-3,
        "critic_rate": 1e-3,
        "final_rate": 0.1,
        "actor_hidden": (64, 64),
        "critic_hidden": (64, 64),
        "layer_norm": True,
        "entropy": "tuned",
        "target_entropy": -5.0,
        "learning_rate": 1.0,
        "optimistic": "auto",
        "relabel": True,
    }
)
"""What was measured to be best on the tasks of the paper that run on numpy."""

PRESETS = MappingProxyType({"default": DEFAULT, "paper": PAPER})

_FROM_FORMULA: Mapping[str, object] = {
    "optimistic": False,
    "demo_replay": 0.0,
    "warm_start": "none",
    "warm_start_steps": 0,
    "target_entropy": -1.0,
}
_FROM_STATES: Mapping[str, object] = {
    **_FROM_FORMULA,
    "segment": False,
    "end_on_sink": False,
    "relabel": False,
}

OF_ALGORITHM: MappingProxyType[str, Mapping[str, object]] = MappingProxyType(
    {
        "lcer": {**_FROM_FORMULA, "relabel": True},
        "cycler": {**_FROM_FORMULA, "relabel": True},
        "drl2": {**_FROM_FORMULA, "gamma_between": 0.999},
        "gail": _FROM_STATES,
        "pwil": _FROM_STATES,
        "sqil": {**_FROM_STATES, "demo_replay": 0.5},
    }
)
"""What an algorithm is, in any preset: what it may use, and what it knows of the formula."""

DEFAULT_OF: MappingProxyType[str, Mapping[str, object]] = MappingProxyType(
    {"pwil": {"learning_rate": 0.1}}
)
"""What differs in the default preset: PWIL pays the same step differently each time."""


def preset_of(preset: str, algorithm: str) -> dict[str, object]:
    """What settings are where nothing is said."""
    own = {} if preset == "paper" else DEFAULT_OF.get(algorithm, {})
    return {**PRESETS.get(preset, DEFAULT), **OF_ALGORITHM.get(algorithm, {}), **own}


def what_it_is(algorithm: str) -> set[str]:
    """The settings that make a method what it is."""
    return set(OF_ALGORITHM.get(algorithm, ()))
