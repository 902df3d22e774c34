"""CyclER: rewards for advancing along accepting cycles (Shah et al., TMLR 2025).

Faithful: the automaton's simple cycles through acceptance, 1/|C| for each of a cycle's edges that
is taken for the first time since the last accepting visit, the cycle that pays most for a stretch
between two visits, and counterfactual experience (`relabel`). Reconstructed: cycles are cut at each
visit, as stretches are; ways from the first state to acceptance count as well, or a first stretch
off every cycle would pay nothing; the discounts are LCER's; of a step that is read from another
automaton state, those edges count as taken that the stretch took.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np
import torch
from torch import Tensor

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.algorithm.arrivals import Eventual
from tiloilc.learn.algorithm.method import Episode, Setup
from tiloilc.learn.algorithm.tiloil import input_states
from tiloilc.learn.engine.replay import Batch
from tiloilc.product import Floats, Int, Walk

MAX_EDGES = 24
"""Which edges of a cycle were taken is kept as bits of a float32, which holds 24 exactly."""

MAX_CYCLES = 1000
"""There can be exponentially many; the tasks of the paper have at most a few dozen."""

Cycle = tuple[tuple[int, int], ...]
"""The edges (b, b') of a way to the next accepting visit, from the one before or the start."""


class CyclER(Eventual):
    """Kept of each step: which cycle pays, and which of its edges were taken before, as bits."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.pays = torch.zeros_like(self.pays)  # cycles pay for acceptance, too
        code = input_states(setup.walk, setup.settings)
        self.code = code.numpy()
        self.cycles = accepting_cycles(setup.walk, self.code)
        if not self.cycles:
            problem = f"every accepting cycle has more than {MAX_EDGES} edges"
            raise CompileError(Diagnostic.of("JOB610", name="cycler", problem=problem))
        device = setup.generator.device
        states = setup.walk.states
        self.places = np.full((len(self.cycles), states, states), -1)
        for place, cycle in zip(self.places, self.cycles, strict=True):
            place[tuple(zip(*cycle, strict=True))] = np.arange(len(cycle))
        self.place = torch.from_numpy(self.places).to(device)[:, code]
        self.edges = np.array([len(cycle) for cycle in self.cycles])
        self.share = torch.tensor(1 / self.edges, dtype=torch.float32, device=device)

    @property
    def columns(self) -> int:
        """The cycle and its edges."""
        return 2

    def judge(self, episode: Episode) -> Floats:
        """The cycle that pays most for each step's stretch, and what was taken of it before."""
        kept = np.zeros((len(episode.state), self.columns), dtype=np.float32)
        visits = np.flatnonzero(self.walk.accepting[episode.arrived]) + 1
        for first, last in zip([0, *visits], [*visits, len(kept)], strict=True):
            state, arrived = self.code[episode.state[first:last]], episode.arrived[first:last]
            cycle, taken = best_cycle(self.places[:, state, arrived], self.edges)
            kept[first:last, 0], kept[first:last, 1] = cycle, taken
        return kept

    def extra(self, batch: Batch, options: Tensor) -> Tensor:
        """1/|C| for an edge of the cycle that was not taken before."""
        cycle, taken = batch.kept.long().unbind(-1)
        place = self.place[cycle[..., None], batch.state[..., None], options]
        fresh = (taken[..., None] >> place.clamp(min=0)) & 1 == 0
        return self.share[cycle][..., None] * ((place >= 0) & fresh)


def best_cycle(places: Int, edges: Int) -> tuple[int, Int]:
    """The cycle that pays most for a stretch, and which of its edges were taken before each step.

    `places` [cycle, m] says which edge of each cycle a step is, -1 for none; `edges` [cycle] how
    many each has. The first of equals. Edges are bits, [m].
    """
    bits = np.where(places >= 0, 1 << places.clip(min=0), 0)
    taken = np.bitwise_or.accumulate(np.pad(bits, ((0, 0), (1, 0))), axis=1)
    paid = [bin(all_taken).count("1") for all_taken in taken[:, -1].tolist()]
    best = int((np.array(paid) / edges).argmax())
    return best, taken[best, :-1]


def accepting_cycles(walk: Walk, code: Int) -> list[Cycle]:
    """Simple ways from acceptance, or from the first state, to acceptance, short ones first.

    These are the cycles through acceptance, cut where a visit ends a stretch. `code` [states] is
    the state that each is read as: edges begin in such states only.
    """
    ahead = [sorted(set(row.reshape(-1).tolist()) - {walk.sink}) for row in walk.options]
    starts = sorted({walk.initial, *code[walk.accepting].tolist()})
    found = {cycle for start in starts for cycle in islice(_ways(ahead, walk, start), MAX_CYCLES)}
    return sorted(found, key=lambda cycle: (len(cycle), cycle))


def _ways(ahead: list[list[int]], walk: Walk, start: int) -> Iterator[Cycle]:
    """The simple ways from `start` to the next acceptance, which may be `start` itself."""
    open_ways: list[tuple[Cycle, frozenset[int]]] = [((), frozenset({start}))]
    while open_ways:
        way, seen = open_ways.pop()
        at = way[-1][1] if way else start
        for after in ahead[at]:
            longer = (*way, (at, after))
            if walk.accepting[after]:
                yield longer
            elif after not in seen and len(longer) < MAX_EDGES:
                open_ways.append((longer, seen | {after}))
