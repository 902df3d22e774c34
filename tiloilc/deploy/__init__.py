"""Trained policies on their own: acting beside any environment, and exported to other programs."""

from tiloilc.deploy.export import EXPORTED, export
from tiloilc.deploy.policy import Policy, load_policy, usual_policy

__all__ = ["EXPORTED", "Policy", "export", "load_policy", "usual_policy"]
