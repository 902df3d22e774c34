"""Exact values of Eq. 4 on small products, by soft value iteration in the open.

Written from the paper and from what the settings say, not from the learner: explicit loops over
cells, automaton states and actions, in float64.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.learn.examples import cell_is, plan
from tests.plan.automata import automaton, ring, stabilization
from tiloilc.automaton.ldba import Ldba
from tiloilc.demos import DemoSet
from tiloilc.learn import make_loop
from tiloilc.learn.agent.tabular import TabularAgent
from tiloilc.plan import Plan

SIZE, GAMMA = 5, 0.9
MOST = 1 / (1 - GAMMA)
ACTIONS = 3
"""Left, stay, right on a line of five cells with walls at both ends."""

RING = ring(["right", "left"], "never")
"""A cyclic task: right, left, right, … for ever."""

RISKY = ring(["right"], "middle")
"""From the left there is no way around the deadly middle."""

STAY = stabilization()
"""Acceptance that must be kept, behind a jump; blue is deadly."""

PASSING = automaton(["right", "left"], 3, lambda b, true: min(b + ("right" in true), 2), {1}, None)
"""1 accepts until `right` is seen again, and then never more: 2 is live in name only."""

PRODUCTS = {"ring": RING, "risky": RISKY, "stay": STAY, "passing": PASSING}

CELLS = {RING: (4, 0, 9), RISKY: (4, 2), STAY: (4, 0), PASSING: (4, 0)}
"""Where each automaton's propositions hold."""

Values = NDArray[np.float64]


def labels_of(ldba: Ldba) -> Callable[[Any], Any]:
    return cell_is(*CELLS[ldba])


def task(ldba: Ldba, **changes: object) -> Plan:
    """One agent on the line that begins anywhere; plain maxima unless `entropy` is given."""
    given = {"gamma": GAMMA, "seeds": 1, "preset": "paper", "learning_rate": 1.0, "entropy": 0.0}
    return plan(ldba, "TestsLine-v0", kwargs={"size": SIZE, "start": None}, **{**given, **changes})


def moved(cell: int, action: int) -> int:
    """Where the line leads."""
    return min(max(cell + action - 1, 0), SIZE - 1)


def pay_of(made: Plan, b: int) -> float:
    """Eq. 8 with f = 0, and the sink's own reward."""
    stages = made.stages
    return made.train.sink_reward if b == made.ldba.sink else stages.index[b] / stages.length[b]


def soft_values(q: Values, alpha: float) -> Values:
    """V = E_π[Q − α log π] with π ∝ exp(Q / α), written with π; the maximum if α = 0."""
    if alpha == 0:
        return q.max(-1)
    weight = np.exp((q - q.max(-1, keepdims=True)) / alpha)
    policy = weight / weight.sum(-1, keepdims=True)
    return (policy * (q - alpha * np.log(policy))).sum(-1)


def exact(made: Plan, rounds: int = 400) -> Values:
    """Q [cell, b, action] of the product of the line with `made`'s automaton, f being 0.

    Where jumps take a step, the product is that of definition 2.3: every (s, b) has the actions of
    the line and one for each jump.
    """
    ldba, s = made.ldba, made.train
    lost, alpha = s.sink_reward * MOST, float(s.entropy)
    letters = [int(x) for x in labels_of(ldba)(np.arange(SIZE, dtype=np.float32)[:, None])]
    q = np.zeros((SIZE, len(ldba.states), ACTIONS))

    def entered(v: Values, cell: int, b: int) -> float:
        """What arriving in (cell, b) is worth."""
        if s.exact_entry and s.segment and b in ldba.accepting:
            return MOST
        if s.exact_entry and b == ldba.sink:
            return lost
        return float(v[cell, b])

    def with_jumps(v: Values, cell: int, b: int) -> float:
        """Being in (cell, b) with its jumps as further actions: R + γ times what comes after."""
        jumps = [pay_of(made, b) + GAMMA * float(v[cell, t]) for t in ldba.jump_targets[b]]
        return max([entered(v, cell, b), *jumps])

    for _ in range(rounds):
        v, new = soft_values(q, alpha), np.zeros_like(q)
        for cell in range(SIZE):
            for b in ldba.states:
                for action in range(ACTIONS):
                    after = moved(cell, action)
                    letter = letters[after]
                    if s.epsilon == "free":
                        options = ldba.options(b, letter)
                        worth = max(entered(v, after, c) for c in options)
                    else:
                        options = (ldba.successor(b, letter),)
                        worth = with_jumps(v, after, options[0])
                    if b not in ldba.accepting or not s.segment:
                        new[cell, b, action] = pay_of(made, b) + GAMMA * worth
                    elif s.accepting_target == "constant":
                        new[cell, b, action] = MOST
                    else:
                        kept = [
                            v[after, c]
                            if c in ldba.accepting
                            else (lost if c == ldba.sink else MOST)
                            for c in options
                        ]
                        new[cell, b, action] = 1 + GAMMA * max(kept)
        q = new
    return q


def swept(made: Plan, shown: DemoSet | None = None, sweeps: int = 150) -> TabularAgent:
    """An agent that has seen every (cell, b, action) at once, again and again; f untrained."""
    agent = make_loop(made, shown or DemoSet(()), labels_of(made.ldba)).agent
    assert isinstance(agent, TabularAgent)
    states = [0] if made.train.relabel else made.ldba.states
    every = np.array([(c, b, a) for c in range(SIZE) for b in states for a in range(3)])
    cell, b, action = every.T[:, None]  # each [seed, copy]
    after = np.clip(cell + action - 1, 0, SIZE - 1)
    letter = labels_of(made.ldba)(after.reshape(-1, 1)).reshape(after.shape)
    seen, arrived = cell[..., None].astype(np.float32), after[..., None].astype(np.float32)
    agent.record(seen, action, arrived, b, letter, np.zeros(b.shape, dtype=np.bool_), b)
    learn_all(agent, sweeps)
    return agent


def learn_all(agent: TabularAgent, sweeps: int) -> None:
    """Learn the latest step of every copy, as an episode of its own, so many times."""
    _, *shape = agent.recent.rows["state"].shape
    for _ in range(sweeps):
        agent.finish(np.ones(shape, dtype=np.bool_), np.ones(shape, dtype=np.int64))
        agent.learn(0)
