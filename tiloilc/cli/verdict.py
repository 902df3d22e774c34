"""What a run achieved, as a few lines for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import mean, stdev

ROWS = (
    ("greedy", "best by validation, greedy"),
    ("stochastic", "best by validation, sampled"),
    ("last", "at the end, greedy"),
    ("cloning", "cloning alone, greedy"),
)


def verdict(evaluation: Mapping[str, object], first: str = "greedy") -> str:
    """A table of policies by metric (mean ± standard deviation over seeds), and the optimum."""
    rows = sorted(ROWS, key=lambda row: row[0] != first)
    lines = [f"{'':30}{'accepting visits':>18}{'violations':>13}{'success':>10}"]
    for key, name in rows:
        judged = evaluation.get(key)
        if isinstance(judged, Mapping):
            visits = _spread(judged["accepting_visits"])
            rates = [_share(judged[metric]) for metric in ("violation_rate", "success")]
            lines.append(f"{name:30}{visits:>18}{rates[0]:>13}{rates[1]:>10}")
    optimum = evaluation.get("optimum")
    if isinstance(optimum, Mapping):
        kind = "optimum" if optimum["exact"] else "optimum, at least"
        lines.append(f"{kind:30}{float(optimum['accepting_visits']):>18.2f}")
    return "\n".join(lines)


def _spread(values: Sequence[float]) -> str:
    return f"{mean(values):.2f} ± {stdev(values) if len(values) > 1 else 0.0:.2f}"


def _share(values: Sequence[float]) -> str:
    return f"{mean(values):.1%}"
