"""What an algorithm adds to soft Q-learning, in networks or tables: what steps are worth.

An algorithm is a class with these methods, made from a `Setup`. Distributions register theirs by an
entry point of the group `tiloilc.algorithms`, whose name is what `train.algorithm` says.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Protocol

import numpy as np
import torch
from torch import Generator, Tensor

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.engine.cells import Cells
from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State
from tiloilc.plan import Stages
from tiloilc.product import Floats, Int, Walk
from tiloilc.spec.settings import ALGORITHM_GROUP, ALGORITHMS, Settings


@dataclass(frozen=True, slots=True)
class Setup:
    """What a method is made of.

    `demonstrations` [rows, d] are states of demonstrations that got somewhere, `capacity` is how
    many transitions of each seed are kept, `horizon` how many steps an episode has at most. All
    that is random comes from `generator`, and what is learned lies on its device. `cells` numbers
    the observations of a finite task that is learned in a table.
    """

    settings: Settings
    stages: Stages
    walk: Walk
    demonstrations: Tensor
    capacity: int
    horizon: int
    generator: Generator
    cells: Cells | None = None

    @property
    def dimensions(self) -> int:
        """The numbers in an observation."""
        return self.demonstrations.shape[1]


@dataclass(frozen=True, slots=True)
class Episode:
    """A whole episode of m steps: the states `after` [m, d] that they led to, and the automaton's
    `state` before and where it `arrived` [m].
    """

    after: Floats
    state: Int
    arrived: Int


@dataclass(frozen=True, slots=True)
class Backup:
    """What each option b' is worth, given V(s', b'): `pay` + `discount` · V.

    Both are [seed, n, K], or [seed, n, 1] where it is the same for all. As they do not depend on V,
    tables compute them for a whole episode before they learn it step by step.
    """

    pay: Tensor
    discount: Tensor

    def each(self, value: Tensor) -> Tensor:
        """The worth of each option, [seed, n, K]; `value` [seed, n, K] is V(s', b')."""
        return self.pay + self.discount * value

    def best(self, value: Tensor) -> Tensor:
        """The worth of the best option, [seed, n]."""
        return self.each(value).amax(-1)


class Method(Protocol):
    """What the backbone asks of an algorithm, for all seeds at once.

    While steps are collected, arrays are [seed, copy, …]; in an update, tensors are [seed, n, …].
    An update asks `draw`, `learn`, `backup`, in this order; on tables `draw` and `learn` are asked
    when episodes have ended only.
    """

    @property
    def columns(self) -> int:
        """How many numbers are kept beside each transition; with any, steps are learned once their
        episode is over and judged."""

    def see(self, after: Floats, state: Int, arrived: Int) -> None:
        """The states [seed, copy, d] that a step has led to; b before and after it [seed, copy]."""

    def judge(self, episode: Episode) -> Floats:
        """What is kept of each step of an episode that is over, [m, columns]: `Batch.kept`."""

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """A finished segment's states [m, d], for the stage buffer of that number."""

    def draw(self) -> State:
        """What the next `learn` needs of chance."""

    def learn(self, chance: State) -> dict[str, Tensor]:
        """One update of what is learned besides Q and policy; losses [seed] by name."""

    def backup(self, batch: Batch, options: Tensor) -> Backup:
        """What Q of each transition should be: the best of this, by V of each of the `options`.

        `options` [seed, n, K] are the b' that there are on arrival. V(s', b') is, on networks,
        E[min Q − α log π] over today's policy.
        """

    def least(self, batch: Batch, options: Tensor) -> Backup | None:
        """What `backup` is at least, whatever is learned.

        By it demonstrations bound values on tables; None: they do not.
        """

    def worth(self, observation: Tensor, options: Tensor) -> Backup:
        """What arriving in each of `options` [seed, n, K] is worth: the greatest is taken.

        Where jumps take no step it depends on the options alone: exported policies go by it.
        """

    def reward(self, observation: Tensor, state: Tensor) -> Tensor:
        """What being in (s, b) pays, [seed, n]; for pictures."""

    def policy(self) -> State:
        """What `worth` needs beside V; each tensor's first axis is a multiple of the seeds."""

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""

    def rings(self) -> dict[str, Ring]:
        """What is too large to be saved whole each time, by name."""

    def state(self) -> State:
        """Everything else that learning goes on from."""

    def load(self, state: State) -> None:
        """Take what `state` gave."""


class Plain:
    """A method that learns nothing besides Q and policy; `backup` is left to say."""

    def __init__(self, setup: Setup) -> None:
        self.settings, self.walk = setup.settings, setup.walk

    @property
    def columns(self) -> int:
        """Nothing is kept."""
        return 0

    def see(self, after: Floats, state: Int, arrived: Int) -> None:
        """Nothing is kept."""

    def judge(self, episode: Episode) -> Floats:
        """Nothing is kept."""
        return np.zeros((len(episode.state), self.columns), dtype=np.float32)

    def segment(self, seed: int, buffer: int, observations: Floats) -> None:
        """Nothing is kept."""

    def draw(self) -> State:
        """Nothing is random."""
        return {}

    def learn(self, chance: State) -> dict[str, Tensor]:
        """Nothing is learned."""
        return {}

    def least(self, batch: Batch, options: Tensor) -> Backup | None:
        """Nothing is known."""
        return None

    def worth(self, observation: Tensor, options: Tensor) -> Backup:
        """V(s', b')."""
        ones = torch.ones(options.shape, device=options.device)
        return Backup(0 * ones, ones)

    def reward(self, observation: Tensor, state: Tensor) -> Tensor:
        """No state pays by itself."""
        return torch.zeros(state.shape)

    def policy(self) -> State:
        """Nothing is needed."""
        return {}

    def load_policy(self, state: State) -> None:
        """Nothing is needed."""

    def rings(self) -> dict[str, Ring]:
        """Nothing is kept."""
        return {}

    def state(self) -> State:
        """Nothing is kept."""
        return {}

    def load(self, state: State) -> None:
        """Nothing is kept."""


def arrivals_of(method: Method, walk: Walk, seeds: int, anywhere: Tensor) -> State:
    """What arriving in each automaton state is worth beside V, `pay` and `discount` [seed, states].

    An exported policy jumps by these. `anywhere` [d] is any observation. Nothing where jumps take
    a step: what they are worth depends on where.
    """
    if walk.costly:
        return {}
    options = torch.arange(walk.states, device=anywhere.device).expand(seeds, 1, -1)
    worth = method.worth(anywhere.expand(seeds, 1, -1), options)
    return {
        "pay": worth.pay.expand(options.shape)[:, 0].contiguous(),
        "discount": worth.discount.expand(options.shape)[:, 0].contiguous(),
    }


def rewards_of(method: Method, observations: Tensor, seeds: int, states: int) -> Tensor:
    """What `method` pays for s [n, d] in each automaton state b: [seed, b, n]."""
    n, device = len(observations), observations.device
    seen = observations.repeat(states, 1).expand(seeds, -1, -1)
    state = torch.arange(states, device=device).repeat_interleave(n).expand(seeds, -1)
    return method.reward(seen, state).view(seeds, states, n)


def make_method(setup: Setup) -> Method:
    """The method that `settings.algorithm` names.

    Raises CompileError JOB610 if it is somebody else's and cannot be made.
    """
    name = setup.settings.algorithm
    if name in ALGORITHMS:
        return _own(name)(setup)
    point = _registered(name)
    try:
        if point is None:
            raise LookupError("no installed package registers it")
        method: Method = point.load()(setup)
    except Exception as error:
        problem = str(error) or type(error).__name__
        raise CompileError(Diagnostic.of("JOB610", name=name, problem=problem)) from error
    return method


def _own(name: str) -> Callable[[Setup], Method]:
    from tiloilc.learn.algorithm.cycler import CyclER
    from tiloilc.learn.algorithm.drl2 import DRL2
    from tiloilc.learn.algorithm.gail import GAIL
    from tiloilc.learn.algorithm.lcer import LCER
    from tiloilc.learn.algorithm.pwil import PWIL
    from tiloilc.learn.algorithm.sqil import SQIL
    from tiloilc.learn.algorithm.tiloil import TiLoIL

    own: dict[str, Callable[[Setup], Method]] = {
        "tiloil": TiLoIL,
        "cloning": TiLoIL,
        "lcer": LCER,
        "cycler": CyclER,
        "drl2": DRL2,
        "gail": GAIL,
        "pwil": PWIL,
        "sqil": SQIL,
    }
    return own[name]


def _registered(name: str) -> EntryPoint | None:
    return next(iter(entry_points(group=ALGORITHM_GROUP, name=name)), None)
