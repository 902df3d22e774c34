"""What a verification found: of each agent, of all, and of any policy (`verify.json`)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from fractions import Fraction

from tiloilc.evaluate.seeds import EVALUATION
from tiloilc.evaluate.statistics import Interval
from tiloilc.evaluate.verify.exact import Exact, Maximum
from tiloilc.evaluate.verify.told import Path
from tiloilc.plan import Plan, digest

VERIFY, SCHEMA_VERSION = "verify.json", 1


@dataclass(frozen=True, slots=True)
class Sampled:
    """Trials of one agent, or of all together: `fine` of `episodes` did what was wanted.

    `violated` led into the sink. `bounds` hold the probability of what was wanted, and `lost` that
    of a violation, each with the confidence asked for.
    """

    fine: int
    violated: int
    episodes: int
    bounds: Interval
    lost: Interval

    @property
    def rate(self) -> float:
        """The share that did."""
        return self.fine / self.episodes


@dataclass(frozen=True, slots=True)
class Judged:
    """One agent: what is known of it exactly, or from trials.

    `walked` are the long walks that should agree with what is known exactly.
    """

    seed: int
    found: Exact | Sampled
    walked: Sampled | None = None

    @property
    def agrees(self) -> bool:
        """Whether the bounds of its walks hold what its own run of the automaton accepts."""
        if self.walked is None or isinstance(self.found, Sampled):
            return True
        bounds = self.walked.bounds
        return bounds.low <= self.found.accepted <= bounds.high

    @property
    def probability(self) -> float:
        """That of doing what is wanted, or the share of trials that did."""
        return float(self.found.probability if isinstance(self.found, Exact) else self.found.rate)

    @property
    def low(self) -> Fraction:
        """What the probability is at least: for certain, or with the confidence asked for."""
        if isinstance(self.found, Exact):
            return self.found.probability
        return Fraction(self.found.bounds.low)


@dataclass(frozen=True, slots=True, eq=False)
class Counterexample:
    """A way in which an agent fails: when it came to each stage, and what went wrong.

    `probability` is that of the way where it is known.
    """

    seed: int
    path: Path
    way: tuple[str, ...]
    reason: str
    probability: float | None


@dataclass(frozen=True, slots=True)
class Simulated:
    """How trials were made. `pooled` are those of all agents: of one drawn among them each time.

    `needed` episodes would say it to within `half_width` whatever the probability is, `needed_here`
    where it is the share of all trials; None is too many to say. The agents `alike` passed the same
    automaton states in all their episodes; `all_alike` says that so did all of them, or the expert.
    """

    confidence: float
    episodes: int
    horizon: int
    visits: int
    pooled: Sampled
    half_width: float
    needed: int | None
    needed_here: int | None
    all_alike: bool
    alike: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Walked:
    """Walks in the environment beside what is exact: `episodes` of each agent, of `steps` steps.

    One is fine if it does not violate and comes to acceptance in its second half, too.
    """

    confidence: float
    episodes: int
    steps: int


@dataclass(frozen=True, slots=True, eq=False)
class Verification:
    """The whole of it. `simulated` is None where all is exact, and `walked` where nobody walked.

    Of a task alone nobody is judged; trials are those of its `expert`, if it has one. `why` says
    why it is not exact. `counterexamples` begin with that of the agent that does worst.
    """

    plan: Plan
    policy: str
    judged: tuple[Judged, ...]
    simulated: Simulated | None
    maximum: Maximum | None
    counterexamples: tuple[Counterexample, ...]
    why: str = ""
    expert: str = ""
    walked: Walked | None = None

    def missing(self, wanted: float) -> tuple[int, ...]:
        """The seeds of agents of which it is not shown that they reach `wanted`."""
        return tuple(judged.seed for judged in self.judged if judged.low < _as_written(wanted))

    def possible(self, wanted: float) -> bool:
        """Whether it is shown that some policy reaches `wanted`: by the maximum, or the expert."""
        if self.maximum is not None and self.maximum.probability >= _as_written(wanted):
            return True
        return bool(self.expert) and (
            self.simulated is not None and self.simulated.pooled.bounds.low >= wanted
        )

    def to_json(self) -> dict[str, object]:
        """The fields of `verify.json`."""
        maximum = self.maximum
        return {
            "schema_version": SCHEMA_VERSION,
            "name": self.plan.name,
            "plan_digest": digest(self.plan),
            "goal": self.plan.goal,
            "policy": self.policy or None,
            "expert": self.expert or None,
            "method": "simulated" if self.simulated else "exact",
            "why_not_exact": self.why or None,
            "agents": [_judged_json(judged) for judged in self.judged],
            "simulated": _simulated_json(self.simulated),
            "walked": None if self.walked is None else asdict(self.walked),
            "maximum": None
            if maximum is None
            else {
                **_fraction_json(maximum.probability),
                "exact": maximum.exact,
                "how": maximum.how,
            },
            "counterexamples": [self._counterexample_json(c) for c in self.counterexamples],
        }

    def _counterexample_json(self, counterexample: Counterexample) -> dict[str, object]:
        ldba, stages, path = self.plan.ldba, self.plan.stages, counterexample.path
        rows = zip(
            path.observations.tolist(), path.letters.tolist(), path.states.tolist(), strict=True
        )
        steps = [
            {
                "step": t,
                "observation": observation,
                "true": [p for i, p in enumerate(ldba.propositions) if letter >> i & 1],
                "state": state,
                "stage": None if state == ldba.sink else stages.index[state],
            }
            for t, (observation, letter, state) in enumerate(rows)
        ]
        return {
            "seed": counterexample.seed,
            "probability": counterexample.probability,
            "way": list(counterexample.way),
            "reason": counterexample.reason,
            "lost_at": path.lost(ldba),
            "loop_from": path.loop,
            "steps": steps,
        }


def _as_written(number: float) -> Fraction:
    """0.9 is nine tenths, not the float beside it: what is exact is compared exactly."""
    return Fraction(str(number))


def _judged_json(judged: Judged) -> dict[str, object]:
    found = judged.found
    if isinstance(found, Sampled):
        return {"seed": judged.seed, **_sampled_json(found)}
    return {
        "seed": judged.seed,
        **_fraction_json(found.probability),
        "at_least": found.at_least,
        "accepted_by_its_own_run": float(found.accepted),
        "chain_states": found.nodes,
        "walked": None if judged.walked is None else _sampled_json(judged.walked),
        "agrees": None if judged.walked is None else judged.agrees,
    }


def _sampled_json(found: Sampled) -> dict[str, object]:
    return {
        "probability": found.rate,
        "low": found.bounds.low,
        "high": found.bounds.high,
        "fine": found.fine,
        "violated": found.violated,
        "violation_low": found.lost.low,
        "violation_high": found.lost.high,
        "episodes": found.episodes,
    }


def _simulated_json(found: Simulated | None) -> dict[str, object] | None:
    if found is None:
        return None
    return {
        "confidence": found.confidence,
        "episodes": found.episodes,
        "horizon": found.horizon,
        "visits": found.visits,
        "first_episode_seed": EVALUATION,
        "pooled": _sampled_json(found.pooled),
        "half_width": found.half_width,
        "episodes_needed": found.needed,
        "episodes_needed_at_this_rate": found.needed_here,
        "alike": list(found.alike),
    }


def _fraction_json(value: Fraction) -> dict[str, object]:
    return {"probability": float(value), "fraction": str(value)}
