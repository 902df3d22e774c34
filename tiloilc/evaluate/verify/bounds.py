"""Bounds of a probability from independent trials (Clopper and Pearson 1934)."""

from __future__ import annotations

from tiloilc.evaluate.statistics import Interval

MOST = 100_000_000
"""Trials beyond which nobody is told how many would be needed."""


def clopper_pearson(successes: int, trials: int, confidence: float) -> Interval:
    """The interval that holds the probability with at least this confidence, whatever it is.

    Each end is the probability at which so many successes, or so few, would be as rare as half of
    what the confidence leaves.
    """
    from scipy.stats import beta

    assert 0 <= successes <= trials, f"{successes} of {trials}"
    assert trials > 0, "no trials"
    tail, failures = (1.0 - confidence) / 2.0, trials - successes
    low = float(beta.ppf(tail, successes, failures + 1)) if successes else 0.0
    high = float(beta.ppf(1.0 - tail, successes + 1, failures)) if failures else 1.0
    return Interval(low, high)


def trials_needed(rate: float, half_width: float, confidence: float) -> int | None:
    """Trials after which the interval is not wider than twice `half_width`, and with one less is.

    Of a share `rate` of successes, rounded down to whole ones. With 1/2 the interval is widest: so
    many do whatever the share is. None if it were more than MOST.
    """
    assert 0.0 <= rate <= 1.0
    assert 0.0 < half_width < 1.0

    def too_wide(trials: int) -> bool:
        found = clopper_pearson(int(rate * trials), trials, confidence)
        return found.high - found.low > 2 * half_width

    high = 1
    while too_wide(high):
        high *= 2
        if high > MOST:
            return None
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if too_wide(middle) else (low, middle)
    return high
