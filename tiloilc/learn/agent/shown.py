"""Demonstrations as an agent sees them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tiloilc.demos import DemoSet, Replay
from tiloilc.learn.algorithm.method import Episode, Method
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec import Demonstrations


@dataclass(frozen=True, slots=True)
class Shown:
    """Steps of demonstrations through the product, and the states of their segments.

    `observation` and `next_observation` are [n, d], `state` and `arrived` (b before and after the
    step) and `letter` (of the next observation) [n], `action` [n, m] in the environment's units if
    recorded ones may be used. `lengths` are the steps of each demonstration, in their order.
    `positive` [k, d] are the states that fill the accepting stage buffers.
    """

    observation: Floats
    next_observation: Floats
    state: Int
    letter: Int
    arrived: Int
    action: Floats | None
    lengths: tuple[int, ...]
    positive: Floats

    @classmethod
    def states_only(cls, positive: Floats) -> Shown:
        """Nothing but the states [k, d] of segments: no steps."""
        empty = np.zeros((0, positive.shape[1]), dtype=np.float32)
        none = np.zeros(0, dtype=np.int64)
        return cls(empty, empty, none, none, none, None, (), positive)


def show(
    demos: DemoSet,
    replays: Sequence[Replay],
    walk: Walk,
    settings: Demonstrations,
    dimensions: int,
    cut: bool,
) -> Shown:
    """What the agent may see of `demos`, given where each went in the automaton.

    With `actions: none` there are no steps, just states: then only the discriminators use them.
    `cut` says whether segments end at accepting states.
    """
    empty = np.zeros((0, dimensions), dtype=np.float32)
    positive = [
        demo.observations[first:last]
        for demo, replay in zip(demos.episodes, replays, strict=True)
        for first, last in _segments(walk.accepting[replay.states].tolist(), cut)
    ]
    states = np.concatenate([empty, *positive])
    if settings.actions == "none" or not demos.episodes:
        return Shown.states_only(states)
    action = None
    if settings.actions == "recorded":
        recorded = [np.asarray(demo.actions).reshape(demo.steps, -1) for demo in demos.episodes]
        action = np.concatenate(recorded).astype(np.float32)
    return Shown(
        np.concatenate([demo.observations[:-1] for demo in demos.episodes]),
        np.concatenate([demo.observations[1:] for demo in demos.episodes]),
        np.concatenate([replay.states[:-1] for replay in replays]),
        np.concatenate([replay.letters[1:] for replay in replays]),
        np.concatenate([replay.states[1:] for replay in replays]),
        action,
        tuple(demo.steps for demo in demos.episodes),
        states,
    )


def judged_demonstrations(method: Method, shown: Shown) -> Floats:
    """What `method` keeps of the steps that were shown, [n, columns]."""
    kept = [np.zeros((0, method.columns), dtype=np.float32)]
    first = 0
    for length in shown.lengths:
        rows = slice(first, first + length)
        episode = Episode(shown.next_observation[rows], shown.state[rows], shown.arrived[rows])
        kept.append(method.judge(episode))
        first += length
    return np.concatenate(kept)


def strange_states(walk: Walk, shown: Shown) -> NDArray[np.bool_]:
    """The automaton states, [B], that no demonstration was in."""
    return ~np.isin(np.arange(walk.states), np.concatenate([shown.state, shown.arrived]))


def _segments(accepting: list[bool], cut: bool) -> list[tuple[int, int]]:
    """The stretches that lead to acceptance; the whole, if there is none (appendix F.3).

    Staying in acceptance is no segment of its own.
    """
    if not cut or not any(accepting):
        return [(0, len(accepting))]
    found, first = [], 0
    for t, accepts in enumerate(accepting):
        if accepts:
            if first < t or t == 0 or not accepting[t - 1]:
                found.append((first, t + 1))
            first = t + 1
    return found
