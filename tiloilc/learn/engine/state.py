"""The state of things that learn, as named tensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias, TypeVar

from torch import Tensor

State: TypeAlias = dict[str, Tensor]
Part = TypeVar("Part")


def with_prefix(prefix: str, state: Mapping[str, Part]) -> dict[str, Part]:
    """The same parts under `prefix.name`."""
    return {f"{prefix}.{name}": tensor for name, tensor in state.items()}


def under(prefix: str, state: Mapping[str, Tensor]) -> State:
    """The tensors that `with_prefix` put under `prefix`."""
    start = prefix + "."
    return {name[len(start) :]: t for name, t in state.items() if name.startswith(start)}
