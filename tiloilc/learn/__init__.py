"""The only place that knows torch: networks, buffers, targets, agents, the loop, checkpoints."""

from tiloilc.learn.agent.protocol import Agent, Policy
from tiloilc.learn.agent.shown import Shown
from tiloilc.learn.run.events import last_events
from tiloilc.learn.run.job import Labels, make_agent, make_loop
from tiloilc.learn.run.train import (
    CHECKPOINTS,
    EVENTS,
    POLICIES,
    Metrics,
    Outcome,
    Watched,
    load_policy,
    train,
    trained_agent,
)

__all__ = [
    "CHECKPOINTS",
    "EVENTS",
    "POLICIES",
    "Agent",
    "Labels",
    "Metrics",
    "Outcome",
    "Policy",
    "Shown",
    "Watched",
    "last_events",
    "load_policy",
    "make_agent",
    "make_loop",
    "train",
    "trained_agent",
]
