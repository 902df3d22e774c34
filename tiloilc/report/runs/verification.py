"""What `tiloilc verify` left in a run folder (`verify.json`), as far as a report tells it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tiloilc.evaluate.records import Json
from tiloilc.report.runs.reading import Object, Unfit, integer, mapping, parse

__all__ = ["Agent", "Failure", "Verification", "read_verification"]


@dataclass(frozen=True)
class Agent:
    """How likely one seed's policy does what is asked, or at least; bounds where it was sampled.

    `seed` is None for all agents together, of which one is drawn for each episode.
    """

    seed: int | None
    probability: float
    at_least: bool
    low: float | None
    high: float | None
    episodes: int | None


@dataclass(frozen=True)
class Failure:
    """One way in which a policy fails, in words; `probability` is that of the way."""

    seed: int
    reason: str
    way: tuple[str, ...]
    probability: float | None


@dataclass(frozen=True)
class Verification:
    """`maximum` is the most that any policy could reach, or a lower bound of it.

    An exact one is about infinite behaviour. A sampled one is about episodes of `horizon` steps
    without a violation and with `visits` accepting visits; `pooled` is of all agents, `confidence`
    that of the bounds.
    """

    exact: bool
    why_not_exact: str
    policy: str
    agents: tuple[Agent, ...]
    pooled: Agent | None
    horizon: int | None
    visits: int | None
    confidence: float | None
    maximum: float | None
    maximum_exact: bool
    maximum_how: str
    failures: tuple[Failure, ...]


def read_verification(file: Path) -> Verification | None:
    """What verification left; None if it left nothing. Raises Unfit for a damaged file."""
    if not file.is_file():
        return None
    try:
        fields = parse(file.read_text(encoding="utf-8"), file.name)
    except UnicodeDecodeError:
        raise Unfit(f"{file.name} is damaged") from None
    maximum = mapping(fields.get("maximum"), f"`maximum` of {file.name}")
    simulated = mapping(fields.get("simulated"), f"`simulated` of {file.name}")
    pooled = mapping(simulated.get("pooled"), f"`pooled` of {file.name}")
    return Verification(
        exact=fields.get("method") == "exact",
        why_not_exact=str(fields.get("why_not_exact") or ""),
        policy=str(fields.get("policy") or ""),
        agents=tuple(_agent(one, file.name) for one in _list(fields, "agents", file.name)),
        pooled=_agent(pooled, file.name) if pooled else None,
        horizon=_whole(simulated.get("horizon")),
        visits=_whole(simulated.get("visits")),
        confidence=_float(simulated.get("confidence")),
        maximum=_float(maximum.get("probability")),
        maximum_exact=maximum.get("exact") is not False,
        maximum_how=str(maximum.get("how") or ""),
        failures=tuple(
            _failure(one, file.name) for one in _list(fields, "counterexamples", file.name)
        ),
    )


def _agent(fields: Object, name: str) -> Agent:
    probability = _float(fields.get("probability"))
    if probability is None:
        raise Unfit(f"{name}: an agent has no probability")
    seed = fields.get("seed")
    return Agent(
        None if seed is None else integer(seed, f"`seed` of {name}"),
        probability,
        fields.get("at_least") is True,
        _float(fields.get("low")),
        _float(fields.get("high")),
        _whole(fields.get("episodes")),
    )


def _failure(fields: Object, name: str) -> Failure:
    way = fields.get("way")
    return Failure(
        integer(fields.get("seed"), f"`seed` of {name}"),
        str(fields.get("reason") or ""),
        tuple(str(step) for step in way) if isinstance(way, list) else (),
        _float(fields.get("probability")),
    )


def _list(fields: Object, key: str, name: str) -> list[Object]:
    value = fields.get(key) or []
    if not isinstance(value, list):
        raise Unfit(f"`{key}` of {name} is no list")
    return [mapping(one, f"an entry of `{key}` of {name}") for one in value]


def _whole(value: Json) -> int | None:
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def _float(value: Json) -> float | None:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
