"""The state of things that learn, as named tensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import torch
from torch import Tensor

State: TypeAlias = dict[str, Tensor]


def with_prefix(prefix: str, state: Mapping[str, Tensor]) -> State:
    """The same tensors under `prefix.name`."""
    return {f"{prefix}.{name}": tensor for name, tensor in state.items()}


def under(prefix: str, state: Mapping[str, Tensor]) -> State:
    """The tensors that `with_prefix` put under `prefix`."""
    start = prefix + "."
    return {name[len(start) :]: t for name, t in state.items() if name.startswith(start)}


def adam_state(adam: torch.optim.Adam, prefix: str) -> State:
    """An optimiser's moments, by parameter."""
    state = adam.state_dict()["state"]
    return {f"{prefix}.{i}.{k}": v for i, entry in state.items() for k, v in entry.items()}


def load_adam(adam: torch.optim.Adam, state: Mapping[str, Tensor], prefix: str) -> None:
    """Take the moments that `adam_state` gave."""
    own = adam.state_dict()
    moments: dict[int, dict[str, Tensor]] = {}
    for name, value in state.items():
        if name.startswith(prefix + "."):
            number, key = name[len(prefix) + 1 :].split(".")
            moments.setdefault(int(number), {})[key] = value
    adam.load_state_dict({"state": moments, "param_groups": own["param_groups"]})
