"""Perceptrons with leading stacked axes: one program for all seeds, twins and stages."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor


class StackedMLP:
    """`stack` independent perceptrons, ReLU between layers; weights [stack, in, out].

    Initialised as PyTorch's Linear: uniform in ±1/√in. `layer_norm` normalises before each ReLU,
    without learned scale.
    """

    def __init__(
        self, stack: int, sizes: Sequence[int], generator: torch.Generator, layer_norm: bool = False
    ) -> None:
        self.stack, self.sizes, self.layer_norm = stack, tuple(sizes), layer_norm
        self.weights: list[Tensor] = []
        self.biases: list[Tensor] = []
        for inputs, outputs in pairwise(sizes):
            bound = 1 / math.sqrt(inputs)
            weight = torch.empty(stack, inputs, outputs).uniform_(
                -bound, bound, generator=generator
            )
            bias = torch.empty(stack, 1, outputs).uniform_(-bound, bound, generator=generator)
            self.weights.append(weight.requires_grad_())
            self.biases.append(bias.requires_grad_())

    @property
    def parameters(self) -> list[Tensor]:
        """All parameters, layer by layer."""
        return [p for pair in zip(self.weights, self.biases, strict=True) for p in pair]

    def __call__(self, x: Tensor) -> Tensor:
        """Inputs [stack, n, in] to outputs [stack, n, out]."""
        last = len(self.weights) - 1
        for i, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            x = torch.baddbmm(bias, x, weight)
            if i < last:
                if self.layer_norm:
                    x = torch.nn.functional.layer_norm(x, x.shape[-1:])
                x = torch.relu(x)
        return x

    def clone(self) -> StackedMLP:
        """A copy with parameters of its own that take no gradient."""
        copy = object.__new__(StackedMLP)
        copy.stack, copy.sizes, copy.layer_norm = self.stack, self.sizes, self.layer_norm
        copy.weights = [w.detach().clone() for w in self.weights]
        copy.biases = [b.detach().clone() for b in self.biases]
        return copy

    def follow(self, other: StackedMLP, tau: float) -> None:
        """Move every parameter by `tau` towards the other's (Polyak averaging)."""
        with torch.no_grad():
            torch._foreach_lerp_(self.parameters, [p.detach() for p in other.parameters], tau)

    def state(self, prefix: str) -> dict[str, Tensor]:
        """Named parameters, for a checkpoint."""
        return {f"{prefix}.{i}": p.detach() for i, p in enumerate(self.parameters)}

    def load(self, state: dict[str, Tensor], prefix: str) -> None:
        """Take the parameters that `state` gave."""
        with torch.no_grad():
            for i, parameter in enumerate(self.parameters):
                parameter.copy_(state[f"{prefix}.{i}"])


def adam(parameters: list[Tensor], rate: float) -> torch.optim.Adam:
    """Adam in its fused form."""
    return torch.optim.Adam(parameters, lr=rate, fused=True)
