"""tiloilc: compile a YAML task file with a temporal-logic formula into a trained agent."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from tiloilc.deploy import Policy

__version__ = "0.1.0"


def load_policy(run: str | Path, *, seed: int | None = None, policy: str | None = None) -> Policy:
    """The policy of one agent that the run in the folder `run` left, to act in any environment.

    `seed` is one of the run's seeds, by default the one that did best in validation; `policy` is
    `best` (by validation), `last` or `cloning`, by default the best or, where nothing was
    validated, the last. Raises CompileError RUN701, RUN706 or RUN708.
    """
    from tiloilc.deploy import load_policy

    return load_policy(run, seed=seed, policy=policy)
