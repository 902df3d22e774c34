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

from tiloilc.learn.engine.state import State

NORM_EPSILON = 1e-5
"""Added to the variance that layer normalisation divides by, as in torch."""

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8
"""Adam's, as everywhere."""


def product(a: Tensor, b: Tensor, out: Tensor | None = None) -> Tensor:
    """Stacked matrix product, [stack, n, k] by [stack, k, m], into `out` if given.

    numpy's library multiplies many small matrices faster than torch's batched product does (a
    third less time for ten seeds of 64 units) and costs less to call; both see the same memory.
    """
    if a.shape[2] == 1:
        return torch.mul(a, b, out=out)
    if a.device.type != "cpu" or torch.compiler.is_compiling():
        if b.shape[2] == 1 and torch.compiler.is_compiling():
            return (a * b.transpose(1, 2)).sum(2, keepdim=True)
        return torch.bmm(a, b, out=out)
    if out is not None:
        np.matmul(a.numpy(), b.numpy(), out=out.numpy())
        return out
    return torch.from_numpy(np.matmul(a.numpy(), b.numpy()))


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

    All parameters are views of `flat`, their gradients of `gradient`, so that an optimiser's step
    is one operation. Initialised as PyTorch's Linear: uniform in ±1/√in. `layer_norm` normalises
    before each ReLU, without learned scale.
    """

    def __init__(
        self, stack: int, sizes: Sequence[int], generator: torch.Generator, layer_norm: bool = False
    ) -> None:
        self.stack, self.sizes, self.layer_norm = stack, tuple(sizes), layer_norm
        count = sum(stack * (inputs + 1) * outputs for inputs, outputs in pairwise(self.sizes))
        self.flat = torch.empty(count, device=generator.device)
        self.gradient = torch.zeros_like(self.flat)
        self.weights, self.biases = self._views(self.flat)
        self._to_weights, self._to_biases = self._views(self.gradient)
        for weight, bias in zip(self.weights, self.biases, strict=True):
            bound = 1 / math.sqrt(weight.shape[1])
            for parameter in (weight, bias):
                parameter.uniform_(-bound, bound, generator=generator)

    @property
    def _layers(self) -> list[tuple[Tensor, Tensor]]:
        """Weights and biases by layer. A compiler must see that they are parts of `flat`."""
        compiling = torch.compiler.is_compiling()
        views = self._views(self.flat) if compiling else (self.weights, self.biases)
        return list(zip(*views, strict=True))

    def _views(self, flat: Tensor) -> tuple[list[Tensor], list[Tensor]]:
        weights: list[Tensor] = []
        biases: list[Tensor] = []
        start = 0
        for inputs, outputs in pairwise(self.sizes):
            for views, size in ((weights, inputs), (biases, 1)):
                shape = (self.stack, size, outputs)
                views.append(flat[start : start + math.prod(shape)].view(shape))
                start += math.prod(shape)
        return weights, biases

    @property
    def parameters(self) -> list[Tensor]:
        """All parameters, layer by layer."""
        return [p for pair in zip(self.weights, self.biases, strict=True) for p in pair]

    @property
    def slopes(self) -> list[Tensor]:
        """What `backward` found for each of `parameters`."""
        return [p for pair in zip(self._to_weights, self._to_biases, strict=True) for p in pair]

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
        if self.flat.device.type != "cpu" or self.layer_norm:
            return self(torch.from_numpy(x).to(self.flat)).cpu().numpy()
        *hidden, (weight, bias) = [(w.numpy(), b.numpy()) for w, b in self._layers]
        for inner, shift in hidden:
            x = np.maximum(np.matmul(x, inner) + shift, 0)
        return np.asarray(np.matmul(x, weight) + bias)

    def backward(self, tape: Tape, slope: Tensor) -> Tensor:
        """The slope at `flat` of a loss that has `slope` [stack, n, out] at the outputs.

        The next call writes over what this one returns.
        """
        found: list[Tensor] = []
        for i, at_layer in self._slopes(tape, slope):
            before = tape.inputs[i].transpose(1, 2)
            if torch.compiler.is_compiling():
                found = [product(before, at_layer), at_layer.sum(1, keepdim=True), *found]
            else:
                torch.sum(at_layer, 1, keepdim=True, out=self._to_biases[i])
                product(before, at_layer, out=self._to_weights[i])
        return torch.cat([t.flatten() for t in found]) if found else self.gradient

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
        copy.flat, copy.gradient = self.flat.clone(), torch.zeros_like(self.flat)
        copy.weights, copy.biases = copy._views(copy.flat)
        copy._to_weights, copy._to_biases = copy._views(copy.gradient)
        return copy

    def follow(self, other: StackedMLP, tau: float) -> None:
        """Move every parameter by `tau` towards the other's (Polyak averaging)."""
        self.flat.lerp_(other.flat, tau)

    def state(self, prefix: str) -> State:
        """Named parameters, for a checkpoint."""
        return {f"{prefix}.{i}": p for i, p in enumerate(self.parameters)}

    def load(self, state: State, prefix: str) -> None:
        """Take the parameters that `state` gave."""
        for i, parameter in enumerate(self.parameters):
            parameter.copy_(state[f"{prefix}.{i}"])


class Adam:
    """Adam (Kingma and Ba 2015) on all parameters of a stack at once."""

    def __init__(self, flat: Tensor, rate: float) -> None:
        self.flat = flat
        self.first_rate, self.rate = rate, torch.tensor(rate, device=flat.device)
        self.mean, self.square = torch.zeros_like(flat), torch.zeros_like(flat)
        self.steps = torch.zeros((), device=flat.device)

    def step(self, gradient: Tensor) -> None:
        """Move the parameters against their `gradient`."""
        self.steps += 1
        if torch.compiler.is_compiling():
            self.mean.lerp_(gradient, 1 - BETA1)
            self.square.lerp_(gradient.square(), 1 - BETA2)
            size = self.rate / (1 - BETA1**self.steps)
            spread = (self.square / (1 - BETA2**self.steps)).sqrt() + EPSILON
            self.flat.sub_(size * self.mean / spread)
            return
        torch._fused_adam_(
            [self.flat],
            [gradient],
            [self.mean],
            [self.square],
            [],
            [self.steps],
            lr=self.rate,
            beta1=BETA1,
            beta2=BETA2,
            weight_decay=0.0,
            eps=EPSILON,
            amsgrad=False,
            maximize=False,
        )

    def slow(self, share: float) -> None:
        """From now on step by `share` of the first step size."""
        self.rate.fill_(self.first_rate * share)

    def reset(self) -> None:
        """Forget all momentum: for the moment when a loss changes its meaning."""
        for moment in (self.mean, self.square, self.steps):
            moment.zero_()

    def state(self, prefix: str) -> State:
        """The moments, for a checkpoint."""
        return {
            f"{prefix}.mean": self.mean,
            f"{prefix}.square": self.square,
            f"{prefix}.steps": self.steps,
        }

    def load(self, state: State, prefix: str) -> None:
        """Take what `state` gave."""
        self.mean.copy_(state[f"{prefix}.mean"])
        self.square.copy_(state[f"{prefix}.square"])
        self.steps.copy_(state[f"{prefix}.steps"])
