"""One agent's greedy actions and values in numpy, from what a run saved of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float32]
Int: TypeAlias = NDArray[np.int64]
Arrays: TypeAlias = Mapping[str, NDArray[Any]]
Layers: TypeAlias = tuple[tuple[Floats, Floats], ...]
"""Weights [in, out] and biases [out], layer by layer, with ReLU between."""

NORM_EPSILON = 1e-5
"""Added to the variance that layer normalisation divides by, as in training."""


@dataclass(frozen=True, eq=False)
class Networks:
    """The actor of a continuous task, and its twin critics for choosing among ε-jumps.

    `told` [states, states] is what the networks are told of each automaton state. `pay` and
    `discount` [states]: arriving in b is worth `pay` + `discount` · V.
    """

    middle: Floats
    half: Floats
    low: Floats
    high: Floats
    told: Floats
    pay: Floats
    discount: Floats
    actor: Layers
    critics: tuple[Layers, Layers]
    layer_norm: bool

    @property
    def dimensions(self) -> int:
        """Numbers in an observation."""
        return int(self.middle.size)

    @property
    def limits(self) -> tuple[NDArray[Any], NDArray[Any]]:
        """The least and the greatest observation that can be read, [d] each: any."""
        infinite = np.full(self.dimensions, np.inf)
        return -infinite, infinite

    def act(self, observations: Floats, states: Int) -> NDArray[Any]:
        """Actions [n, …] in the environment's units, of s [n, d] in b [n]."""
        scaled = self._scaled_action(self._inputs(observations, states))
        shape = (len(scaled), *self.low.shape)
        return self.low + 0.5 * (scaled.reshape(shape) + 1) * (self.high - self.low)

    def values(self, observations: Floats, states: Int) -> Floats:
        """What arriving in b is worth, of s [n, d] and b [n]: [n]. V is the less of two critics."""
        x = self._inputs(observations, states)
        joint = np.concatenate([x, self._scaled_action(x)], axis=1)
        judged = [_forward(layers, joint, self.layer_norm)[:, 0] for layers in self.critics]
        return self.pay[states] + self.discount[states] * np.minimum(*judged)

    def _inputs(self, observations: Floats, states: Int) -> Floats:
        return np.concatenate([(observations - self.middle) / self.half, self.told[states]], axis=1)

    def _scaled_action(self, x: Floats) -> Floats:
        return np.tanh(_forward(self.actor, x, False)[:, : self.low.size])


@dataclass(frozen=True, eq=False)
class Table:
    """Q [cell, state, action] of a finite task; cells are numbered from `low`, `sizes` wide.

    `code` [states] is the state whose row stands for each. `floor` [cell, state] is what each is
    worth at least, `alpha` the temperature of its value, `pay` and `discount` as in Networks.
    """

    q: Floats
    low: Int
    sizes: Int
    first_action: int
    code: Int
    pay: Floats
    discount: Floats
    floor: Floats
    alpha: float

    @property
    def dimensions(self) -> int:
        """Numbers in an observation."""
        return int(self.low.size)

    @property
    def limits(self) -> tuple[NDArray[Any], NDArray[Any]]:
        """The least and the greatest observation that can be read, [d] each."""
        return self.low, self.low + self.sizes - 1

    def act(self, observations: Floats, states: Int) -> NDArray[Any]:
        """The actions of greatest value, [n]."""
        best = self.q[self._cells(observations), self.code[states]].argmax(-1)
        return np.asarray(best + self.first_action)

    def values(self, observations: Floats, states: Int) -> Floats:
        """What arriving in b is worth, of s [n, d] and b [n]: [n]."""
        cells, code = self._cells(observations), self.code[states]
        q = self.q[cells, code]
        soft = q.max(-1)
        if self.alpha > 0:
            beyond = np.exp((q - soft[:, None]) / self.alpha).sum(-1)
            soft = soft + self.alpha * np.log(beyond)
        value: Floats = np.maximum(soft, self.floor[cells, code])
        return self.pay[states] + self.discount[states] * value

    def _cells(self, observations: Floats) -> Int:
        whole = np.moveaxis(observations.astype(np.int64) - self.low, -1, 0)
        cells: Int = np.ravel_multi_index(tuple(whole), tuple(self.sizes.tolist()))
        return cells


Actor: TypeAlias = Networks | Table


def actor_of(arrays: Arrays, seeds: int, seed: int, layer_norm: bool) -> Actor:
    """The agent in place `seed` of a policy file's arrays; `layer_norm` is that of its critics."""
    fixed = {k.removeprefix("fixed."): v for k, v in arrays.items() if k.startswith("fixed.")}
    own = {
        k: v.reshape(seeds, len(v) // seeds, *v.shape[1:])[seed]
        for k, v in arrays.items()
        if not k.startswith("fixed.")
    }
    if "q" in own:
        return Table(
            own["q"][0],
            fixed["low"],
            fixed["sizes"],
            int(fixed["first_action"]),
            fixed["code"],
            own["arrival.pay"][0],
            own["arrival.discount"][0],
            fixed["floor"],
            float(own["alpha"][0]),
        )
    first, second = (_layers(own, "critics", twin) for twin in (0, 1))
    return Networks(
        fixed["middle"],
        fixed["half"],
        fixed["low"],
        fixed["high"],
        np.eye(len(fixed["code"]), dtype=np.float32)[fixed["code"]],
        own["arrival.pay"][0],
        own["arrival.discount"][0],
        _layers(own, "actor", 0),
        (first, second),
        layer_norm,
    )


def _layers(arrays: Arrays, name: str, place: int) -> Layers:
    """Of `name.0`, `name.1`, …: weights [stack, in, out] and biases [stack, 1, out] in turn."""
    count = sum(key.startswith(f"{name}.") for key in arrays)
    parameters = [arrays[f"{name}.{i}"][place] for i in range(count)]
    return tuple(
        (weight, bias[0]) for weight, bias in zip(parameters[::2], parameters[1::2], strict=True)
    )


def _forward(layers: Sequence[tuple[Floats, Floats]], x: Floats, normalised: bool) -> Floats:
    """[n, in] to [n, out]."""
    for weight, bias in layers[:-1]:
        x = x @ weight + bias
        if normalised:
            x = x - x.mean(-1, keepdims=True)
            x = x / np.sqrt(np.square(x).mean(-1, keepdims=True) + np.float32(NORM_EPSILON))
        x = np.maximum(x, 0)
    weight, bias = layers[-1]
    return x @ weight + bias
