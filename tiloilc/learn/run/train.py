"""One training run in its folder: events, checkpoints, policies; interrupted and resumed."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, TypeAlias

import torch
from safetensors.torch import load_file, save

from tiloilc.demos import DemoSet
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.agent.protocol import Agent, Policy
from tiloilc.learn.engine.state import State, under, with_prefix
from tiloilc.learn.run.best import Best
from tiloilc.learn.run.board import Board
from tiloilc.learn.run.checkpoint import (
    Checkpoint,
    Checkpoints,
    load_checkpoint,
    not_written,
    replace_file,
)
from tiloilc.learn.run.events import Events
from tiloilc.learn.run.job import Labels, make_loop
from tiloilc.learn.run.loop import Loop
from tiloilc.learn.run.tally import Tally
from tiloilc.plan import Plan, digest

if TYPE_CHECKING:
    from gymnasium.spaces import Space

EVENTS, CHECKPOINTS = "events.jsonl", "checkpoints"
POLICIES = ("cloning", "best", "last")
"""The policies a run leaves: after cloning alone, each seed's best by validation, at the end."""

Metrics: TypeAlias = Mapping[str, Sequence[float | None]]
"""Values by name, one a seed."""

Validate: TypeAlias = Callable[[Policy], Metrics]
"""Judges the greedy policy of every seed without touching its random generator."""


@dataclass(frozen=True, slots=True)
class Watched:
    """What a progress display may show after a step; the arrays are the loop's own."""

    step: int
    steps: int
    exploring: bool
    tally: Tally
    metrics: Metrics | None


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a run ended: at `step` of `steps`, after `seconds` of training in all."""

    step: int
    steps: int
    seconds: float

    @property
    def interrupted(self) -> bool:
        """Whether steps are left."""
        return self.step < self.steps


def train(
    plan: Plan,
    demos: DemoSet,
    labels: Labels,
    run: Path,
    validate: Validate,
    watch: Callable[[Watched], None],
    about: Mapping[str, object],
    resume: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> Outcome:
    """Train `plan` in the folder `run`, or go on with what is there.

    `about` is what the log says of this run beside the plan. Where a resumed run goes on, it says
    by `say`, and why not from its newest checkpoint if that is damaged. On SIGINT or SIGTERM a
    checkpoint is written and the outcome is interrupted. Killed at any moment, a run goes on from
    its last checkpoint to the same events and weights as one that was never killed.

    Raises CompileError RUN701 to RUN705, RUN709 and RUN710.
    """
    session = _Session(plan, run, make_loop(plan, demos, labels, say), Best(plan.train.seeds))
    kept = session.restore(say) if resume else 0
    settings, loop = plan.train, session.loop
    last = settings.steps_taken
    with (
        Events(run / EVENTS, kept) as events,
        Board(run, loop.step if resume else None) as board,
        Checkpoints(run / CHECKPOINTS, digest(plan), session.resumed) as checkpoints,
        _interrupts() as stop,
    ):
        if not kept:
            events.write("start", 0, **about)
        for step in loop.run(last):
            metrics = None
            if _is_due(step, last, plan) or session.has_just_cloned:
                metrics = session.judge(validate, events, board)
            watch(Watched(step, last, loop.exploring, loop.tally, metrics))
            if metrics is not None:
                loop.tally = Tally.empty(settings.seeds, loop.walk.states)
            due = passed(step, settings.copies, settings.checkpoint_every)
            if due or stop.set or step >= last:
                session.save(checkpoints, events)
            checkpoints.check()
            if stop.set and step < last:
                break
        checkpoints.wait()
        outcome = Outcome(loop.step, last, session.seconds)
        if not outcome.interrupted:
            events.write("end", loop.step)
            session.write_policies()
    return outcome


def load_policy(run: Path, name: str) -> State | None:
    """The policy `name` of POLICIES that a finished run left, None if it has none.

    Raises CompileError RUN701 if it cannot be read.
    """
    path = run / CHECKPOINTS / f"{name}.safetensors"
    if not path.is_file():
        return None
    try:
        return load_file(path)
    except Exception as error:
        raise CompileError(
            Diagnostic.of("RUN701", path=run.as_posix(), problem=f"{path.name} is damaged")
        ) from error


def trained_agent(
    plan: Plan, demos: DemoSet, labels: Labels, run: Path
) -> tuple[Space[Any], Agent] | None:
    """The agent as the last checkpoint in the folder `run` holds it, but for the rows of its rings.

    Before it stands the space of its observations. None without a checkpoint. Raises CompileError
    RUN701 if none is whole, RUN704 if it is of another plan.
    """
    checkpoint = load_checkpoint(run / CHECKPOINTS, digest(plan))
    if checkpoint is None:
        return None
    loop = make_loop(plan, demos, labels)
    loop.agent.load(under("loop.agent", checkpoint.state()))
    return loop.product.copies.observation_space, loop.agent


@dataclass
class _Stop:
    """Whether somebody asked to stop."""

    set: bool = False


@dataclass
class _Session:
    """What a run keeps beside the loop: each seed's best policy, and the cloned one.

    `spent` are the seconds of training before this program.
    """

    plan: Plan
    run: Path
    loop: Loop
    best: Best
    cloning: State = field(default_factory=dict)
    began: float = field(default_factory=time.monotonic)
    spent: float = 0.0
    resumed: Checkpoint | None = None

    @property
    def seconds(self) -> float:
        """How long this run has been trained."""
        return self.spent + time.monotonic() - self.began

    @property
    def has_just_cloned(self) -> bool:
        """Whether the policy is what cloning made of it, before any learning."""
        random = self.plan.train.learning_starts
        return self.loop.cloned and random <= self.loop.step < random + self.plan.train.copies

    def save(self, checkpoints: Checkpoints, events: Events) -> None:
        """Have a checkpoint of everything written, with the length of the event log."""
        state = {
            **with_prefix("loop", self.loop.state()),
            **with_prefix("best", self.best.state()),
            **with_prefix("cloning", self.cloning),
        }
        rings = self.loop.agent.rings()
        checkpoints.save(state, rings, self.loop.step, self.seconds, events.size(), events.sync)

    def restore(self, say: Callable[[str], None]) -> int:
        """Go on from the last checkpoint, if there is one; the event log's length then."""
        resumed = load_checkpoint(self.run / CHECKPOINTS, digest(self.plan))
        if resumed is None:
            say("beginning again: no checkpoint had been written")
            return 0
        state = resumed.state()
        self.loop.load(under("loop", state))
        resumed.restore(self.loop.agent.rings())
        self.best.load(under("best", state))
        self.cloning = under("cloning", state)
        self.resumed, self.spent = resumed, resumed.pointer.seconds
        older = f", from the checkpoint before the last: {resumed.problem}"
        done = self.loop.step >= self.plan.train.steps_taken
        how = "finished already," if done else "going on"
        say(f"{how} at step {self.loop.step:,}" + (older if resumed.problem else ""))
        return resumed.pointer.events_bytes

    def judge(self, validate: Validate, events: Events, board: Board) -> Metrics:
        """Validate, log what happened since the last time, and keep what is best."""
        loop = self.loop
        for name, loss in loop.tally.losses.items():
            if not torch.isfinite(loss).all():
                problem = f"the {name} loss is not finite"
                raise CompileError(Diagnostic.of("RUN702", step=loop.step, problem=problem))
        metrics, happened = validate(loop.agent), loop.tally.event()
        events.write("train", loop.step, **happened)
        events.write("eval", loop.step, greedy=metrics)
        board.write("train", happened, loop.step)
        board.write("eval", metrics, loop.step)
        policy = loop.agent.policy()
        if self.has_just_cloned:
            self.cloning = {name: tensor.clone() for name, tensor in policy.items()}
        elif not loop.exploring:
            visits, violations = metrics["accepting_visits"], metrics["violation_rate"]
            self.best.offer(policy, [v or 0.0 for v in visits], [v or 0.0 for v in violations])
        return metrics

    def write_policies(self) -> None:
        """Write the policies, each with all that acting needs and each seed's validation."""
        agent, folder = self.loop.agent, self.run / CHECKPOINTS
        policies = (self.cloning, self.best.policy, agent.policy())
        fixed = {**with_prefix("fixed", agent.fixed()), "scores": self.best.scores}
        try:
            for name, policy in zip(POLICIES, policies, strict=True):
                if policy:
                    whole = sorted({**policy, **fixed}.items())
                    data = save({k: v.detach().contiguous() for k, v in whole})
                    replace_file(folder / f"{name}.safetensors", data)
        except OSError as error:
            raise not_written(folder, error) from None


def _is_due(step: int, last: int, plan: Plan) -> bool:
    """Whether the policy is judged after `step`: regularly, and at the end."""
    every = plan.evaluate.every or max(plan.train.steps // 20, 1)
    return passed(step, plan.train.copies, every) or step >= last


def passed(step: int, stride: int, every: int) -> bool:
    """Whether a multiple of `every` lies among the last `stride` steps up to `step`."""
    return step // every > (step - stride) // every


@contextmanager
def _interrupts() -> Iterator[_Stop]:
    """While this lasts, SIGINT and SIGTERM ask to stop; a second one stops at once."""
    stop = _Stop()

    def ask(number: int, frame: FrameType | None) -> None:
        if stop.set:
            raise KeyboardInterrupt
        stop.set = True

    try:
        before = {s: signal.signal(s, ask) for s in (signal.SIGINT, signal.SIGTERM)}
    except ValueError:  # not the main thread: nobody can interrupt us anyway
        before = {}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
