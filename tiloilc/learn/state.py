"""The state of things that learn, as named tensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from torch import Tensor

State: TypeAlias = dict[str, Tensor]


def with_prefix(prefix: str, state: Mapping[str, Tensor]) -> State:
    """The same tensors under `prefix.name`."""
    return {f"{prefix}.{name}": tensor for name, tensor in state.items()}


def under(prefix: str, state: Mapping[str, Tensor]) -> State:
    """The tensors that `with_prefix` put under `prefix`."""
    start = prefix + "."
    return {name[len(start) :]: t for name, t in state.items() if name.startswith(start)}
