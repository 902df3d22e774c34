"""From a plan to a training loop that is ready to begin."""

from __future__ import annotations

from collections.abc import Callable

import torch
from gymnasium import spaces
from threadpoolctl import threadpool_limits

from tiloilc.demos import DemoSet, replay_all
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.agent.continuous import SacAgent
from tiloilc.learn.agent.protocol import Agent
from tiloilc.learn.agent.shown import Shown, show
from tiloilc.learn.agent.tabular import TabularAgent
from tiloilc.learn.engine.device import pick_device
from tiloilc.learn.engine.program import Say
from tiloilc.learn.run.loop import Loop
from tiloilc.plan import Plan
from tiloilc.product import Copies, Floats, Int, Segmenter, Walk, walk_tables

Labels = Callable[[Floats], Int]


def make_loop(plan: Plan, demos: DemoSet, labels: Labels, say: Say = lambda text: None) -> Loop:
    """The training loop of `plan` at step 0, all of it seeded by the plan's first seed.

    Sets torch and numpy's library to one thread: the many small products of stacked networks run
    fastest so, and give the same sums on every machine of a kind.
    """
    torch.set_num_threads(1)
    threadpool_limits(1, user_api="blas")
    settings, walk = plan.train, walk_tables(plan.ldba, plan.train.epsilon)
    copies = Copies(plan.environment, settings.seeds * settings.copies)
    shown = _shown(plan, demos, labels, walk, copies)
    agent = make_agent(plan, walk, copies, shown, say)
    segmenter = Segmenter(
        walk,
        plan.stages,
        copies.count,
        plan.environment.horizon,
        copies.dimensions,
        settings.segment,
    )
    return Loop(settings, plan.environment.horizon, walk, copies, labels, agent, segmenter)


def make_agent(
    plan: Plan, walk: Walk, copies: Copies, shown: Shown, say: Say = lambda text: None
) -> Agent:
    """A fresh learner: tabular on finite environments, SAC on others, or as the plan says.

    Raises CompileError JOB604 where cloning is asked of a table, JOB608 for spaces that the
    backbone cannot take, JOB610 for an algorithm that cannot be had, RUN709 if there is too little
    memory, RUN710 if the device is not there.
    """
    settings, stages = plan.train, plan.stages
    seen, actions = copies.observation_space, copies.action_space
    backbone, horizon = settings.backbone, plan.environment.horizon
    if backbone == "auto":
        backbone = "tabular" if copies.finite else "sac"
    if backbone == "tabular" and settings.algorithm == "cloning":
        problem, help = "a table does not clone demonstrations", "use `tiloil`"
        raise CompileError(Diagnostic.of("JOB604", setting="algorithm", problem=problem, help=help))
    if backbone == "tabular" and copies.finite and isinstance(actions, spaces.Discrete):
        generator = torch.Generator().manual_seed(settings.first_seed)
        return TabularAgent(settings, stages, walk, seen, actions, shown, horizon, generator)
    if backbone == "sac" and isinstance(actions, spaces.Box):
        generator = torch.Generator(pick_device(settings.device)).manual_seed(settings.first_seed)
        return SacAgent(settings, stages, walk, seen, actions, shown, horizon, generator, say)
    raise CompileError(
        Diagnostic.of("JOB608", backbone=backbone, seen=str(seen), actions=str(actions))
    )


def _shown(plan: Plan, demos: DemoSet, labels: Labels, walk: Walk, copies: Copies) -> Shown:
    wanted = plan.demonstrations
    used = demos.take(wanted.count)
    cut, replays = replay_all(
        used,
        labels,
        plan.ldba,
        wanted.max_visits,
        lambda b, letter: walk.options[b, letter].tolist(),
    )
    return show(cut, replays, walk, wanted, copies.dimensions, plan.train.segment)
