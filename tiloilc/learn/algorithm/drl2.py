"""DRL²: the automaton as a Markov reward process (Bagatella, Krause and Martius, RLC 2024).

Reconstructed from the paper's abstract and algorithms.md: Dirichlet counts over the automaton's
edges with an optimistic prior, the posterior mean K as a chain, its values U under eventual
discounting as a potential. U is refreshed at each update, the paper's may be older; its prior's
strength is `prior_count`.
"""

from __future__ import annotations

import torch
from torch import Tensor

from tiloilc.learn.algorithm.arrivals import Eventual
from tiloilc.learn.algorithm.method import Backup, Setup
from tiloilc.learn.algorithm.tiloil import input_states
from tiloilc.learn.engine.replay import Batch
from tiloilc.learn.engine.state import State
from tiloilc.product import Floats, Int, Walk


class DRL2(Eventual):
    """Arriving pays Γ(b') U(b') − U(b) on top: progress in the automaton, as far as it is rare."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        seeds, states = setup.settings.seeds, setup.walk.states
        self.code = input_states(setup.walk, setup.settings)
        self.prior = optimistic_prior(setup.walk)[self.code] * setup.settings.prior_count
        self.counts = torch.zeros(seeds, states, states, dtype=torch.float64)
        self.seed = torch.arange(seeds)[:, None]
        self.potential = torch.zeros(seeds, states, device=setup.generator.device)
        self.learn(self.draw())

    def see(self, after: Floats, state: Int, arrived: Int) -> None:
        """Count the edge that each copy has taken."""
        edge = (self.seed.expand(state.shape), torch.from_numpy(state), torch.from_numpy(arrived))
        self.counts.index_put_(edge, torch.ones(state.shape, dtype=torch.float64), accumulate=True)

    def draw(self) -> State:
        """Today's potential; nothing is random.

        States that read alike share their values Q, so they share their edges, too: a potential
        that differed would pay for each visit once more.
        """
        s = self.settings
        accepting = self.accepting.cpu()
        discount = torch.where(accepting, s.gamma, s.gamma_between).double()
        alike = torch.zeros_like(self.counts).index_add_(1, self.code, self.counts)
        counts = self.prior + alike[:, self.code]
        return {"potential": chain_values(counts, accepting, discount).float()}

    def learn(self, chance: State) -> dict[str, Tensor]:
        """Take the potential in."""
        self.potential.copy_(chance["potential"])
        return {}

    def arrive(self, options: Tensor) -> Backup:
        """1[b' ∈ B*] + Γ(b') U(b'), and Γ."""
        now = super().arrive(options)
        return Backup(now.pay + now.discount * self._potential(options), now.discount)

    def extra(self, batch: Batch, options: Tensor) -> Tensor:
        """−U(b)."""
        return -self._potential(batch.state[..., None])

    def policy(self) -> State:
        """The potential, by which jumps are chosen."""
        return {"potential": self.potential}

    def load_policy(self, state: State) -> None:
        """Take what `policy` gave."""
        self.potential.copy_(state["potential"])

    def state(self) -> State:
        """The counts as well."""
        return {**self.policy(), "counts": self.counts}

    def load(self, state: State) -> None:
        """Take what `state` gave."""
        self.load_policy(state)
        self.counts.copy_(state["counts"])

    def _potential(self, states: Tensor) -> Tensor:
        """U of automaton states [seed, n, K]."""
        return self.potential.gather(1, states.flatten(1)).view(states.shape)


def optimistic_prior(walk: Walk) -> Tensor:
    """Each state's edges alike, [states, states]; rows sum to 1.

    None to the sink and none that stays short of acceptance: nobody is expected to fail or to wait.
    A state without any others stays where it is.
    """
    prior = torch.eye(walk.states, dtype=torch.float64)
    for b in range(walk.states):
        hoped = set(walk.options[b].reshape(-1).tolist()) - {walk.sink}
        hoped -= set() if walk.accepting[b] else {b}
        if hoped:
            prior[b] = 0
            prior[b, sorted(hoped)] = 1 / len(hoped)
    return prior


def chain_values(counts: Tensor, accepting: Tensor, discount: Tensor) -> Tensor:
    """U(b) = E[1[b' ∈ B*] + Γ(b') U(b')] under K ∝ `counts` [seed, b, b'], [seed, b].

    `accepting` and `discount` are [b']. With K the chain, U = (I − K Γ)⁻¹ K 1[B*].
    """
    chain = counts / counts.sum(-1, keepdim=True)
    unit = torch.eye(len(accepting), dtype=counts.dtype)
    paid = chain @ accepting.to(counts.dtype)
    values: Tensor = torch.linalg.solve(unit - chain * discount, paid)
    return values
