"""The matrix products of one update and nothing else: no update can be faster than these."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor

from tiloilc.bench.contestants.noise import ACTIONS, OBSERVATIONS
from tiloilc.bench.contestants.sb3 import STATES
from tiloilc.bench.contestants.work import Run, Work

Product = tuple[Tensor, Tensor, Tensor]
"""Left [n, k], right [k, m], where the result goes [n, m]."""


def updates(work: Work) -> Run:
    """The products of one update of SAC, in their order, on one set of weights and activations."""
    torch.set_num_threads(1)
    seen = OBSERVATIONS + STATES
    actor = _Net([seen, *work.actor, 2 * ACTIONS], work.batch)
    critics = [_Net([seen + ACTIONS, *work.critic, 1], work.batch) for _ in range(2)]
    targets = [_Net([seen + ACTIONS, *work.critic, 1], work.batch) for _ in range(2)]
    products = [
        *actor.forward,  # at s'
        *(product for target in targets for product in target.forward),
        *(p for critic in critics for p in critic.forward + critic.weights + critic.inputs[1:]),
        *actor.forward,  # at s
        *(product for critic in critics for product in critic.forward + critic.inputs),
        *actor.weights,
        *actor.inputs[1:],
    ]

    def run(times: int) -> None:
        for _ in range(times):
            for left, right, out in products:
                torch.mm(left, right, out=out)

    return run


class _Net:
    """The products of one perceptron: forward, gradients of weights and of each layer's inputs."""

    def __init__(self, sizes: Sequence[int], batch: int) -> None:
        values = [torch.randn(batch, size) for size in sizes]
        gradients = [torch.randn(batch, size) for size in sizes]
        layers = [torch.randn(k, m) / k for k, m in pairwise(sizes)]
        steps = [torch.empty(k, m) for k, m in pairwise(sizes)]
        self.forward, self.weights, self.inputs = [list[Product]() for _ in range(3)]
        for i, (layer, step) in enumerate(zip(layers, steps, strict=True)):
            self.forward.append((values[i], layer, values[i + 1]))
            self.weights.append((values[i].T, gradients[i + 1], step))
            self.inputs.append((gradients[i + 1], layer.T, gradients[i]))
