"""Perceptrons with leading stacked axes: one program for all seeds, twins and stages.

Gradients are written out: what autograd adds to each of the many small operations costs as much as
half of the products themselves.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tiloilc.learn.engine.products import product
from tiloilc.learn.engine.state import State

NORM_EPSILON = 1e-5
"""Added to the variance that layer normalisation divides by, as in torch."""

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8
"""Adam's, as everywhere."""


@dataclass(frozen=True, slots=True)
class Tape:
    """What a forward pass leaves for the way back: inputs, what went into each ReLU, deviations.

    All tensors are [stack, n, …]; `deviations` are empty without layer normalisation.
    """

    inputs: tuple[Tensor, ...]
    normal: tuple[Tensor, ...]
    deviations: tuple[Tensor, ...]

    def rows(self, rows: slice) -> Tape:
        """The same for some of the n rows."""
        return Tape(
            tuple(t[:, rows] for t in self.inputs),
            tuple(t[:, rows] for t in self.normal),
            tuple(t[:, rows] for t in self.deviations),
        )


class StackedMLP:
    """`stack` independent perceptrons, ReLU between layers; weights [stack, in, out].

    Initialised as PyTorch's Linear: uniform in ±1/√in. `layer_norm` normalises before each ReLU,
    without learned scale.
    """

    def __init__(
        self, stack: int, sizes: Sequence[int], generator: torch.Generator, layer_norm: bool = False
    ) -> None:
        self.stack, self.sizes, self.layer_norm = stack, tuple(sizes), layer_norm
        self.parameters: list[Tensor] = []
        for inputs, outputs in pairwise(self.sizes):
            bound = 1 / math.sqrt(inputs)
            for rows in (inputs, 1):
                parameter = torch.empty(stack, rows, outputs, device=generator.device)
                self.parameters.append(parameter.uniform_(-bound, bound, generator=generator))
        self.slopes = [torch.zeros_like(parameter) for parameter in self.parameters]

    @property
    def weights(self) -> list[Tensor]:
        """[stack, in, out] of each layer."""
        return self.parameters[::2]

    @property
    def biases(self) -> list[Tensor]:
        """[stack, 1, out] of each layer."""
        return self.parameters[1::2]

    @property
    def _layers(self) -> list[tuple[Tensor, Tensor]]:
        return list(zip(self.weights, self.biases, strict=True))

    def __call__(self, x: Tensor) -> Tensor:
        """Inputs [stack, n, in] to outputs [stack, n, out]."""
        return self.forward(x)[0]

    def forward(self, x: Tensor) -> tuple[Tensor, Tape]:
        """Inputs [stack, n, in] to outputs [stack, n, out], and what `backward` needs."""
        inputs, normal, deviations = [], [], []
        layers = self._layers
        last = len(layers) - 1
        for i, (weight, bias) in enumerate(layers):
            inputs.append(x)
            x = product(x, weight).add_(bias)
            if i == last:
                break
            if self.layer_norm:
                x -= x.mean(-1, keepdim=True)
                deviation = x.square().mean(-1, keepdim=True).add_(NORM_EPSILON).sqrt_()
                x /= deviation
                normal.append(x)
                deviations.append(deviation)
                x = x.relu()
            else:
                x = x.relu_()
                normal.append(x)
        return x, Tape(tuple(inputs), tuple(normal), tuple(deviations))

    def on_host(self, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Inputs [stack, n, in] to outputs in numpy, a quarter of the time for few rows."""
        if self.parameters[0].device.type != "cpu" or self.layer_norm:
            return self(torch.from_numpy(x).to(self.parameters[0])).cpu().numpy()
        *hidden, (weight, bias) = [(w.numpy(), b.numpy()) for w, b in self._layers]
        for inner, shift in hidden:
            x = np.maximum(np.matmul(x, inner) + shift, 0)
        return np.asarray(np.matmul(x, weight) + bias)

    def backward(self, tape: Tape, slope: Tensor) -> list[Tensor]:
        """The slopes at `parameters` of a loss that has `slope` [stack, n, out] at the outputs.

        The next call writes over what this one returns.
        """
        found: list[Tensor] = []
        for i, at_layer in self._slopes(tape, slope):
            before = tape.inputs[i].transpose(1, 2)
            if torch.compiler.is_compiling():
                found = [product(before, at_layer), at_layer.sum(1, keepdim=True), *found]
            else:
                product(before, at_layer, out=self.slopes[2 * i])
                torch.sum(at_layer, 1, keepdim=True, out=self.slopes[2 * i + 1])
        return found or self.slopes

    def input_slope(self, tape: Tape, slope: Tensor, last: int) -> Tensor:
        """The loss's slope [stack, n, last] at the `last` components of the inputs."""
        for _, at_layer in self._slopes(tape, slope):
            slope = at_layer
        return product(slope, self._layers[0][0][:, -last:].transpose(1, 2))

    def _slopes(self, tape: Tape, slope: Tensor) -> Iterator[tuple[int, Tensor]]:
        """The loss's slope at what each layer puts out, from the last to the first."""
        layers = self._layers
        yield len(layers) - 1, slope
        for i in reversed(range(len(layers) - 1)):
            slope = product(slope, layers[i + 1][0].transpose(1, 2))
            x = tape.normal[i]
            slope = torch.ops.aten.threshold_backward(slope, x, 0)
            if self.layer_norm:
                along = (slope * x).mean(-1, keepdim=True)
                slope = slope.sub_(slope.mean(-1, keepdim=True)).addcmul_(x, along, value=-1)
                slope = slope.div_(tape.deviations[i])
            yield i, slope

    def clone(self) -> StackedMLP:
        """A copy with parameters of its own."""
        copy = object.__new__(StackedMLP)
        copy.stack, copy.sizes, copy.layer_norm = self.stack, self.sizes, self.layer_norm
        copy.parameters = [parameter.clone() for parameter in self.parameters]
        copy.slopes = [torch.zeros_like(parameter) for parameter in self.parameters]
        return copy

    def follow(self, other: StackedMLP, tau: float) -> None:
        """Move every parameter by `tau` towards the other's (Polyak averaging)."""
        torch._foreach_lerp_(self.parameters, other.parameters, tau)

    def state(self, prefix: str) -> State:
        """Named parameters, for a checkpoint."""
        return {f"{prefix}.{i}": p for i, p in enumerate(self.parameters)}

    def load(self, state: State, prefix: str) -> None:
        """Take the parameters that `state` gave."""
        for i, parameter in enumerate(self.parameters):
            parameter.copy_(state[f"{prefix}.{i}"])


class Adam:
    """Adam (Kingma and Ba 2015) on several parameters at once.

    `decay` are β₁ᵗ and β₂ᵗ: a compiled program would raise them to the power t for each number.
    """

    def __init__(self, parameters: Sequence[Tensor], rate: float) -> None:
        self.parameters = list(parameters)
        device = self.parameters[0].device
        self.first_rate, self.rate = rate, torch.tensor(rate, device=device)
        self.means = [torch.zeros_like(parameter) for parameter in self.parameters]
        self.squares = [torch.zeros_like(parameter) for parameter in self.parameters]
        self.steps = torch.zeros((), device=device)
        self.decay = torch.ones(2, device=device)
        self._betas = torch.tensor([BETA1, BETA2], device=device)

    def step(self, gradients: Sequence[Tensor]) -> None:
        """Move the parameters against their `gradients`."""
        self.steps += 1
        self.decay *= self._betas
        if torch.compiler.is_compiling():
            self._step_to_compile(gradients)
            return
        torch._fused_adam_(
            self.parameters,
            list(gradients),
            self.means,
            self.squares,
            [],
            [self.steps] * len(self.parameters),
            lr=self.rate,
            beta1=BETA1,
            beta2=BETA2,
            weight_decay=0.0,
            eps=EPSILON,
            amsgrad=False,
            maximize=False,
        )

    def _step_to_compile(self, gradients: Sequence[Tensor]) -> None:
        size, spread = self.rate / (1 - self.decay[0]), (1 - self.decay[1]).rsqrt()
        every = zip(self.parameters, gradients, self.means, self.squares, strict=True)
        for parameter, gradient, mean, square in every:
            mean.lerp_(gradient, 1 - BETA1)
            square.lerp_(gradient.square(), 1 - BETA2)
            parameter.sub_(size * mean / (square.sqrt() * spread + EPSILON))

    def slow(self, share: float) -> None:
        """From now on step by `share` of the first step size."""
        self.rate.fill_(self.first_rate * share)

    def reset(self) -> None:
        """Forget all momentum: for the moment when a loss changes its meaning."""
        for moment in (*self.means, *self.squares, self.steps):
            moment.zero_()
        self.decay.fill_(1)

    def state(self, prefix: str) -> State:
        """The moments, for a checkpoint."""
        means = {f"{prefix}.mean.{i}": mean for i, mean in enumerate(self.means)}
        squares = {f"{prefix}.square.{i}": square for i, square in enumerate(self.squares)}
        counts = {f"{prefix}.steps": self.steps, f"{prefix}.decay": self.decay}
        return {**means, **squares, **counts}

    def load(self, state: State, prefix: str) -> None:
        """Take what `state` gave."""
        for name, moment in self.state(prefix).items():
            moment.copy_(state[name])
