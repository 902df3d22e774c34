"""LCER: eventual discounting with counterfactual experience (Voloshin, Verma and Yue, ICML 2023).

Faithful: the reward 1[b' ∈ B*], the discount γ after acceptance and nearly 1 elsewhere, and that
every step is learned from every live automaton state, with that state's own reward and discount.
On networks these states are drawn when a batch is (`relabel`), which stores each step once.
Reconstructed: the discount is that of the state arrived in, so that states which read alike are
worth the same; along a run both count alike.
"""

from __future__ import annotations

from tiloilc.learn.algorithm.arrivals import Eventual


class LCER(Eventual):
    """All of it is eventual discounting and the setting `relabel`."""
