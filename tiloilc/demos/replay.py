"""Demonstrations run through the automaton: the states they pass, where they accept or violate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from tiloilc.automaton.ldba import Ldba, Letter, StateId
from tiloilc.demos.model import DemoSet, Floats, Letters

Labels: TypeAlias = Callable[[Floats], Letters]
"""Observations [n, d] to letters [n]: bit i says whether proposition i holds."""

Options: TypeAlias = Callable[[StateId, Letter], Sequence[StateId]]
"""Where a run may be after a letter; of several the first is the one without a jump."""


@dataclass(frozen=True, slots=True, eq=False)
class Replay:
    """The automaton along one demonstration.

    letters  int64 [T+1]
    states   int64 [T+1]  b_t, the state after the label of observation t; b_0 has read the first
    visits   how many of b_1 … b_T are accepting: what the demonstration *did*
    violates_at  the first t with b_t the sink, None if there is none
    """

    letters: Letters
    states: npt.NDArray[np.int64]
    visits: int
    violates_at: int | None


def replay(
    observations: Floats,
    labels: Labels,
    ldba: Ldba,
    max_visits: int | None = None,
    options: Options | None = None,
) -> Replay:
    """Run one demonstration [T+1, d], cut after `max_visits` accepting visits.

    `options` are those of the product that is trained in; without them jumps are free.

    At ε-jumps it is read in its own favour, the whole of it known: of all runs those that stay out
    of the sink longest, and of these one that accepts most often. It jumps as soon as that leads to
    acceptance, so that all of it shows the way from there; a run that accepts no more does not.
    """
    letters = np.asarray(labels(observations), np.int64)
    states = best_run(letters.tolist(), ldba, options)
    accepting = np.isin(states, sorted(ldba.accepting))
    if max_visits is not None:
        arrivals = np.flatnonzero(accepting[1:]) + 1
        if len(arrivals) >= max_visits:
            end = int(arrivals[max_visits - 1]) + 1
            letters, states, accepting = letters[:end], states[:end], accepting[:end]
    dead = np.flatnonzero(states == (-1 if ldba.sink is None else ldba.sink))
    return Replay(letters, states, int(accepting[1:].sum()), int(dead[0]) if len(dead) else None)


def replay_all(
    demos: DemoSet,
    labels: Labels,
    ldba: Ldba,
    max_visits: int | None = None,
    options: Options | None = None,
) -> tuple[DemoSet, tuple[Replay, ...]]:
    """Replay every demonstration; returns them cut to the length of their replays."""
    replays = tuple(
        replay(demo.observations, labels, ldba, max_visits, options) for demo in demos.episodes
    )
    return demos.cut([len(run.states) - 1 for run in replays]), replays


def best_run(
    letters: Sequence[int], ldba: Ldba, options: Options | None = None
) -> npt.NDArray[np.int64]:
    """The automaton states after each letter, [T+1], by the run that `replay` describes."""
    offered = options or ldba.options
    reached: list[dict[StateId, tuple[StateId, ...]]] = []
    current: tuple[StateId, ...] = (ldba.initial,)
    for letter in letters:
        reached.append({b: tuple(offered(b, letter)) for b in current})
        current = tuple(sorted({o for found in reached[-1].values() for o in found}))
    worth = dict.fromkeys(current, (0, 0))
    choices: list[dict[StateId, StateId]] = []
    for options_of in reversed(reached):
        chosen: dict[StateId, StateId] = {}
        before: dict[StateId, tuple[int, int]] = {}
        for b, reachable in options_of.items():
            values = [_add(worth[o], o, ldba) for o in reachable]
            before[b] = max(values)
            best = [o for o, value in zip(reachable, values, strict=True) if value == before[b]]
            jumps = [o for o in best if o != reachable[0]]
            chosen[b] = jumps[0] if jumps and before[b][1] > 0 else best[0]
        choices.append(chosen)
        worth = before
    run = []
    state = ldba.initial
    for chosen in reversed(choices):
        state = chosen[state]
        run.append(state)
    return np.array(run, np.int64)


def _add(value: tuple[int, int], state: StateId, ldba: Ldba) -> tuple[int, int]:
    """Steps outside the sink and accepting visits from `state` on, itself included."""
    return value[0] + (state != ldba.sink), value[1] + (state in ldba.accepting)
