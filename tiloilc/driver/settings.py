"""What can be said about training settings before training: of a task file, or changed later."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.metadata import entry_points

from tiloilc.automaton.ldba import Ldba
from tiloilc.diag import Diagnostic, Span, did_you_mean
from tiloilc.driver.environment import Asked
from tiloilc.plan import Stages
from tiloilc.seeds import LAST_SEED
from tiloilc.spec import Demonstrations
from tiloilc.spec.settings import ALGORITHM_GROUP, ALGORITHMS, Settings

IMITATING = ("gail", "pwil", "sqil")
"""Algorithms that learn from demonstrations alone. They know of no sinks."""

BY_STEPS = ("cycler", "drl2")
"""Algorithms that pay for steps through the automaton: a jump of its own has no place in them."""

MAX_BETA = 0.5
"""Below it a later stage always pays more than an earlier one (paper, below Eq. 8)."""


Place = Callable[[str], Span | None]
"""Where a setting is given."""


def _nowhere(name: str) -> Span | None:
    return None


def settings_findings(
    settings: Settings, demonstrations: Demonstrations | None, place: Place = _nowhere
) -> Iterator[Diagnostic]:
    """PLAN404, JOB604, JOB609 and JOB610; `place` is where a setting is given."""
    yield from _algorithm_findings(settings.algorithm, place)
    yield from _imitation_findings(settings, demonstrations or Demonstrations(count=0), place)
    if settings.beta >= MAX_BETA:
        beta = f"{settings.beta:g}"
        yield Diagnostic.of("PLAN404", place("beta"), beta=beta, help="1/3 is usual")
    steps, random = settings.steps, settings.learning_starts
    if settings.algorithm != "cloning" and steps <= random:
        yield Diagnostic.of(
            "JOB609",
            place("steps"),
            steps=f"{steps:,}",
            random=f"{random:,}",
            help="raise `steps`, or lower `learning_starts`",
        )
    if settings.algorithm == "cloning" and settings.warm_start == "none":
        problem = "cloning needs a warm start"
        yield _bad("algorithm", problem, "set `warm_start: bc`", place)
    last = settings.first_seed + settings.seeds - 1
    if last > LAST_SEED:
        problem = f"the others count up to {last:,}"
        yield _bad("first_seed", problem, f"no seed goes beyond {LAST_SEED:,}", place)
    yield from _target_findings(settings, place)


def _target_findings(settings: Settings, place: Place) -> Iterator[Diagnostic]:
    """JOB604 where nothing would teach an algorithm what a part of the automaton is worth."""
    name, exact = settings.algorithm, settings.exact_entry
    if settings.end_on_sink and name in IMITATING:
        problem = f"{name} knows no sinks: it must see what comes after one"
        yield _bad("end_on_sink", problem, "set `end_on_sink: false`", place)
    elif settings.end_on_sink and not exact:
        problem = "no step of a sink is seen, so its value must be given"
        yield _bad("end_on_sink", problem, "set `exact_entry: true`", place)
    rests = settings.segment and settings.accepting_target == "segment"
    if name == "tiloil" and rests and not exact:
        problem = "acceptance begins the next segment, so nothing but its exact value pays for it"
        yield _bad("accepting_target", problem, "set `exact_entry: true`", place)
    if name in BY_STEPS and settings.epsilon == "step":
        problem = f"{name} pays for steps of the environment, which a jump is none of"
        yield _bad("epsilon", problem, "set `epsilon: free`, or use `lcer`", place)


def _algorithm_findings(name: str, place: Place) -> Iterator[Diagnostic]:
    """JOB610 where neither this package nor an installed one has the algorithm `name`."""
    if name in ALGORITHMS:
        return
    others = sorted(entry_points(group=ALGORITHM_GROUP).names)
    if name not in others:
        problem = "no installed package has it"
        help = did_you_mean(name, [*ALGORITHMS, *others])
        yield Diagnostic.of("JOB610", place("algorithm"), name=name, problem=problem, help=help)


def backbone_findings(
    settings: Settings,
    demonstrations: Demonstrations | None,
    asked: Asked,
    place: Place = _nowhere,
) -> Iterator[Diagnostic]:
    """JOB604 and JOB608 where the backbone cannot learn in the environment's spaces, or from these
    demonstrations; JOB605 where it would make nothing of them.
    """
    learner = backbone(settings, asked)
    if learner == "sac" and asked.discrete:
        spaces = {"seen": str(asked.observation_space), "actions": str(asked.action_space)}
        help = "use a Box of actions, or fewer and whole-numbered observations"
        yield Diagnostic.of("JOB608", place("backbone"), backbone="sac", help=help, **spaces)
    if learner == "tabular" and not asked.finite:
        problem = "tabular learning needs whole-numbered observations and Discrete actions"
        yield _bad("backbone", problem, "use `sac`, or `auto`", place)
    if learner == "tabular" and settings.algorithm == "cloning":
        problem = "a table learns from demonstrations, it does not clone them"
        yield _bad("algorithm", problem, "use `tiloil`", place)
    if learner == "sac" and demonstrations is not None and demonstrations.count:
        yield from _cloning_findings(settings, demonstrations, place)


def _cloning_findings(
    settings: Settings, demonstrations: Demonstrations, place: Place
) -> Iterator[Diagnostic]:
    """JOB604 and JOB605 where networks would clone demonstrations too early, or not at all."""
    clones = settings.warm_start != "none" and demonstrations.actions != "none"
    infers = settings.demo_replay > 0 and demonstrations.actions == "inferred"
    if settings.learning_starts == 0 and (clones or infers):
        problem = "demonstrations are cloned, and actions inferred, when the random steps are over"
        yield _bad("learning_starts", problem, "2,000 is usual", place)
    learns = settings.algorithm != "cloning"
    if learns and clones and settings.warm_start_steps and settings.demo_replay == 0:
        problem = "while learning, steps are cloned that are in the batch, and none is demonstrated"
        help = "raise `demo_replay`, or set `warm_start_steps: 0`"
        yield _doubtful("warm_start_steps", problem, help, place)


def backbone(settings: Settings, asked: Asked) -> str:
    """What learns: the table or the networks."""
    if settings.backbone == "auto":
        return "tabular" if asked.finite else "sac"
    return settings.backbone


def _imitation_findings(
    settings: Settings, demonstrations: Demonstrations, place: Place
) -> Iterator[Diagnostic]:
    """JOB604 where an algorithm that imitates has nothing to imitate."""
    name = settings.algorithm
    if name in (*IMITATING, "cloning") and demonstrations.count == 0:
        yield _bad("algorithm", f"{name} needs demonstrations", "add some, or use `lcer`", place)
    elif name in ("sqil", "cloning") and demonstrations.actions == "none":
        problem = f"{name} needs the actions of demonstrations"
        yield _bad("algorithm", problem, "set `demonstrations.actions: inferred`", place)
    if name == "sqil" and settings.demo_replay == 0:
        problem = "sqil pays for demonstrated steps alone, of which a batch has none"
        yield _bad("demo_replay", problem, "0.5 is usual", place)


def doubtful_findings(
    settings: Settings,
    ldba: Ldba,
    stages: Stages,
    entropy: float = 0.0,
    tabular: bool = True,
    place: Place = _nowhere,
) -> Iterator[Diagnostic]:
    """JOB605 for settings under which what pays best is not what is asked for.

    `entropy` is the greatest that a policy can have, in nats. What is not known of the environment
    is not doubted. The algorithms that others brought, and baselines, are not TiLoIL's: of them
    only the targets' step is.
    """
    yield from _slow_targets(settings, tabular, place)
    if settings.algorithm not in ("tiloil", "cloning"):
        return
    short = [b for b in ldba.states if stages.distance[b] > 0]
    spread = settings.beta if settings.stages else 1.0
    index = [stages.index[b] if settings.stages else 0 for b in short]
    length = [stages.length[b] if settings.stages else 1 for b in short]
    worst = min(((i - spread) / n for i, n in zip(index, length, strict=True)), default=0.0)
    best = max(((i + spread) / n for i, n in zip(index, length, strict=True)), default=0.0)
    if ldba.sink is not None and settings.sink_reward > worst:
        problem = f"a sink pays {settings.sink_reward:g}, a live state as little as {worst:.3g}"
        yield _doubtful("sink_reward", problem, "set `sink_reward: -1`", place)
    most = 1 / (1 - settings.gamma)
    lingering = 0.0 if settings.entropy == "tuned" else best + float(settings.entropy) * entropy
    if settings.segment and settings.entropy != 0 and lingering > 1:
        worth = f"short of acceptance can be worth {lingering * most:.0f}"
        problem = f"with a fixed temperature to linger {worth}, acceptance is worth {most:.0f}"
        yield _doubtful("entropy", problem, "set `entropy: tuned`", place)
    guessed = ldba.accepting & {target for _, target in ldba.jumps}
    if settings.epsilon == "step" and guessed and settings.accepting_target == "constant":
        problem = (
            "a jump reads no letter and acceptance has a constant value: to jump at once is best"
        )
        yield _doubtful("epsilon", problem, "set `accepting_target: live`", place)


def _slow_targets(settings: Settings, tabular: bool, place: Place) -> Iterator[Diagnostic]:
    updates = max(settings.steps - settings.learning_starts, 0) * settings.updates_per_step
    if not tabular and updates and (1 - settings.tau) ** updates > 0.5:
        problem = (
            f"after all {updates:,.0f} updates the targets are mostly what they were at random"
        )
        yield _doubtful("tau", problem, "0.005 is usual", place)


def _doubtful(setting: str, problem: str, help: str, place: Place) -> Diagnostic:
    return Diagnostic.of("JOB605", place(setting), setting=setting, problem=problem, help=help)


def _bad(setting: str, problem: str, help: str, place: Place) -> Diagnostic:
    return Diagnostic.of("JOB604", place(setting), setting=setting, problem=problem, help=help)
