"""Made-up records: a run of some seeds whose policies make so many visits, at every evaluation."""

from __future__ import annotations

from typing import Any

from tiloilc.evaluate import Record, split_seeds


def records(
    visits: list[float],
    *,
    first_seed: int = 200,
    curve: list[list[float]] | None = None,
    **changes: Any,
) -> list[Record]:
    """One record a seed; `curve` has a list over seeds for each 1000 steps."""
    n = len(visits)
    points = [{"step": 1000 * (i + 1), **judged(row)} for i, row in enumerate(curve or [])]
    evaluation = {
        "name": "flatworld_cycle", "algorithm": "tiloil", "preset": "default",
        "overrides": {"beta": 0.0, "gamma": 0.8, "first_seed": first_seed}, "steps": 54_000,
        "seeds": list(range(first_seed, first_seed + n)), "greedy": judged(visits),
        "last": judged(visits), "stochastic": judged(visits), "cloning": None, "curve": points,
        "optimum": {"accepting_visits": 4.0, "exact": False, "how": "lattice"},
        "interrupted": False, "git_commit": "abcdef0123", "plan_digest": "p", **changes,
    }  # fmt: skip
    return split_seeds(evaluation, "spec")


def judged(visits: list[float]) -> dict[str, list[float]]:
    """All metrics of policies with so many visits; the eventual return is half of them."""
    n = len(visits)
    return {
        "accepting_visits": visits, "violation_rate": [0.0] * n, "success": [1.0] * n,
        "eventual_return": [v / 2 for v in visits], "first_visit": [3.0] * n,
    }  # fmt: skip
