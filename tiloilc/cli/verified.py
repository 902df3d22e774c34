"""A verification as lines for the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fractions import Fraction

    from tiloilc.evaluate.verify import Verification
    from tiloilc.evaluate.verify.exact import Exact
    from tiloilc.evaluate.verify.results import Sampled, Simulated, Walked

SHORT = 11
"""Letters of a fraction beyond which it says less than its decimals."""


def lines(found: Verification) -> Iterator[str]:
    """Whose probabilities these are and how they are known, a row for each agent, and the rest."""
    yield f"{found.plan.name}: {found.plan.goal}"
    if found.simulated is not None:
        yield from (
            _by_expert(found, found.simulated)
            if found.expert
            else _simulated(found, found.simulated)
        )
    elif found.judged:
        yield from _exact(found)
    if found.maximum is not None:
        best = found.maximum
        kind = "any policy at most" if best.exact else "the best policy at least"
        yield f"{kind}: {number(best.probability)} ({best.how})"
    elif not found.judged:
        yield f"nothing is known of what any policy could reach: {found.why}"
    for i, failed in enumerate(found.counterexamples):
        if i == 0:
            likely = failed.probability
            chance = "" if likely in (None, 1.0) else f", likeliest way (probability {likely:.4g})"
            yield f"how seed {failed.seed} fails{chance}:"
            yield from (f"  {line}" for line in failed.way)
            yield f"  {failed.reason}"
        else:
            yield f"how seed {failed.seed} fails: {failed.reason}"


def number(value: Fraction) -> str:
    """Decimals, and the fraction itself where it is short."""
    if value.denominator == 1:
        return str(value)
    decimals = f"{float(value):.6f}"
    if float(decimals) in (0.0, 1.0):  # close to certain is not certain
        decimals = f"{float(value):.3g}" if value < 0.5 else f"1 - {float(1 - value):.3g}"
    return f"{decimals} = {value}" if len(str(value)) <= SHORT else decimals


def _exact(found: Verification) -> Iterator[str]:
    about = found.walked
    yield f"policy `{found.policy}`, without a time limit: exact, by Storm"
    heads = f"{'seed':>6}  {'probability':<22}{'its Markov chain':<18}"
    if about is not None:
        yield (
            f"beside {about.episodes:,} walks of {about.steps:,} steps, fine without violation and"
            " with an accepting visit in the second half"
        )
        heads += f"{'fine walks':>12}  {_percent(about)} bounds"
    yield heads.rstrip()
    for judged in found.judged:
        exact: Exact = judged.found  # type: ignore[assignment]  # nothing was simulated
        shown = f"{'≥ ' if exact.at_least else ''}{number(exact.probability)}"
        chain, walks, note = f"{exact.nodes:,} states", "", ""
        if judged.walked is not None:
            walked = judged.walked
            fine = f"{walked.fine}/{walked.episodes}"
            walks = f"{fine:>12}  {_bounds(walked)}{'' if judged.agrees else ', which miss it'}"
        if exact.accepted != exact.probability:
            note = f"  its own run of the automaton accepts with {number(exact.accepted)}"
        yield f"{judged.seed:>6}  {shown:<22}{chain:<18}{walks}{note}".rstrip()


def _simulated(found: Verification, about: Simulated) -> Iterator[str]:
    yield f"policy `{found.policy}`: {_fine(about)}"
    yield f"by simulation: {found.why}"
    heads = f"{'seed':>6}{'fine':>12}{'violations':>18}{'probability':>13}"
    yield f"{heads}  {_percent(about)} bounds"
    for judged in found.judged:
        sampled: Sampled = judged.found  # type: ignore[assignment]  # all were simulated
        yield f"{judged.seed:>6}{_row(sampled)}"
    if len(found.judged) > 1:
        yield f"{'any':>6}{_row(about.pooled)}  (one of them, drawn anew each time)"
    counts = f"{_count(about.needed)}, or {_count(about.needed_here)} at this rate"
    yield f"episodes for ± {about.half_width:g}: {counts}"
    if about.alike:
        alike = ", ".join(map(str, about.alike))
        yield f"all episodes passed the same automaton states at the same steps: seeds {alike}"


def _by_expert(found: Verification, about: Simulated) -> Iterator[str]:
    yield f"expert `{found.expert}`: {_fine(about)}"
    sampled = about.pooled
    fine = f"{sampled.fine} of {sampled.episodes} episodes"
    yield f"  in {fine}: {sampled.rate:.4f}, {_percent(about)} bounds {_bounds(sampled)}"
    if about.all_alike:
        yield "  all of them passed the same automaton states at the same steps"


def _row(sampled: Sampled) -> str:
    fine = f"{sampled.fine}/{sampled.episodes}"
    violated = f"{sampled.violated} (≤ {sampled.lost.high:.4f})"
    return f"{fine:>12}{violated:>18}{sampled.rate:>13.4f}  {_bounds(sampled)}"


def _bounds(sampled: Sampled) -> str:
    return f"{sampled.bounds.low:.4f} – {sampled.bounds.high:.4f}"


def _fine(about: Simulated) -> str:
    visits = f"{about.visits} accepting visit{'' if about.visits == 1 else 's'} or more"
    return f"no violation and {visits} within {about.horizon} steps"


def _percent(about: Simulated | Walked) -> str:
    return f"{about.confidence * 100:.6g} %"


def _count(episodes: int | None) -> str:
    return "too many" if episodes is None else f"{episodes:,}"
