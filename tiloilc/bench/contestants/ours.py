"""Ourselves: TiLoIL's updates and environment steps, and the product without learning."""

from __future__ import annotations

import dataclasses
from itertools import count

import numpy as np

from tiloilc.bench.contestants.work import WARM_UP, Run, Work
from tiloilc.demos import DemoSet
from tiloilc.driver import compile_spec, labeller
from tiloilc.learn.run.job import make_loop
from tiloilc.learn.run.loop import Loop
from tiloilc.plan import Plan
from tiloilc.product import Copies, Product, walk_tables


def updates(work: Work) -> Run:
    """Updates from a replay of random steps."""
    loop = _loop(work)

    def run(times: int) -> None:
        for _ in range(times):
            loop.agent.learn(0)

    return run


def steps(work: Work) -> Run:
    """Steps of the environment, each with its action, its storing and one update."""
    loop = _loop(work)

    def run(times: int) -> None:
        for _ in loop.run(loop.step + times):
            pass

    return run


def product(work: Work) -> Run:
    """Environment steps of many copies with labels and automaton, actions given."""
    plan = _plan(work)
    copies = Copies(plan.environment, work.copies)
    walk = walk_tables(plan.ldba)
    product = Product(copies, labeller(plan), walk, lambda seen, options: options[:, 0])
    everyone, numbers = np.ones(work.copies, np.bool_), count()
    copies.action_space.seed(0)
    actions = [
        np.array([copies.action_space.sample() for _ in range(work.copies)])
        for _ in range(plan.environment.horizon)
    ]

    def run(times: int) -> None:
        for _ in range(times // work.copies):
            at = next(numbers) % len(actions)
            if at == 0:
                product.reset(list(range(work.copies)), everyone)
            product.step(actions[at])

    return run


def _plan(work: Work) -> Plan:
    plan = compile_spec(work.path).plan
    changes: dict[str, object] = {
        "preset": "paper",
        "steps": 1_000_000_000,
        "seeds": work.seeds,
        "batch_size": work.batch,
        "actor_hidden": work.actor,
        "critic_hidden": work.critic,
        "beta": 1 / 3 if work.discriminators else 0,
        "buffer_size": 100_000,
        "learning_starts": WARM_UP,
        "tau": 0.005,
        "compile": "always" if work.compiled else "never",
        "entropy": "tuned",
        "demo_replay": 0,
        "warm_start": "none",
    }
    return dataclasses.replace(plan, train=plan.train.override(changes))


def _loop(work: Work) -> Loop:
    plan = _plan(work)
    loop = make_loop(plan, DemoSet(()), labeller(plan))
    for _ in loop.run(WARM_UP):
        pass
    return loop
