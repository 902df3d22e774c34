"""The matrix products of one update and nothing else: no update can be faster than these.

Each is done in turn by torch's library or numpy's, into memory that is there, or by our operator:
whichever is fastest.
"""

from __future__ import annotations

import timeit
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor

from tiloilc.bench.contestants.noise import ACTIONS, OBSERVATIONS, STATES
from tiloilc.bench.contestants.work import Run, Work
from tiloilc.learn.engine.products import build

TRIED, TRIALS = 20, 5
"""Updates in a trial of each library, and trials."""

Product = tuple[Tensor, Tensor, Tensor]
"""Left [n, k], right [k, m], where the result goes [n, m]."""


def updates(work: Work) -> Run:
    """The products of one update, by what is fastest."""
    ways = [by_torch(work), by_numpy(work)]
    with suppress(ImportError):
        ways.append(by_operator(work))
    return min(ways, key=_seconds)


def by_torch(work: Work) -> Run:
    """The same by torch's library."""
    torch.set_num_threads(1)
    operands = products(work)

    def run(times: int) -> None:
        for _ in range(times):
            for left, right, out in operands:
                torch.mm(left, right, out=out)

    return run


def by_numpy(work: Work) -> Run:
    """The same by numpy's library."""
    arrays = [tuple(tensor.numpy() for tensor in product) for product in products(work)]

    def run(times: int) -> None:
        for _ in range(times):
            for left, right, out in arrays:
                np.matmul(left, right, out=out)

    return run


def by_operator(work: Work) -> Run:
    """The same by the operator of compiled updates."""
    try:
        build()
    except Exception as error:
        raise ImportError(str(error), name="AVX-512 with a C++ compiler") from error
    operands = [(left[None], right[None]) for left, right, _ in products(work)]
    multiply = torch.ops.tiloilc.product.default

    def run(times: int) -> None:
        for _ in range(times):
            for left, right in operands:
                multiply(left, right)

    return run


def products(work: Work) -> list[Product]:
    """The products of one update of SAC, in their order, on one set of weights and activations."""
    seen = OBSERVATIONS + STATES
    actor = _Net([seen, *work.actor, 2 * ACTIONS], work.batch)
    critics = [_Net([seen + ACTIONS, *work.critic, 1], work.batch) for _ in range(2)]
    targets = [_Net([seen + ACTIONS, *work.critic, 1], work.batch) for _ in range(2)]
    return [
        *actor.forward,  # at s'
        *(product for target in targets for product in target.forward),
        *(p for critic in critics for p in critic.forward + critic.weights + critic.inputs[1:]),
        *actor.forward,  # at s
        *(product for critic in critics for product in critic.forward + critic.inputs),
        *actor.weights,
        *actor.inputs[1:],
    ]


def _seconds(run: Run) -> float:
    """The least time of some updates, after one that warms up."""
    run(1)
    return min(timeit.repeat(lambda: run(TRIED), number=1, repeat=TRIALS))


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
