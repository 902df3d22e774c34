"""A saved policy beside any environment: it reads labels, steps the automaton, and acts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.deploy.actor import Actor, Floats, actor_of
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.driver import labeller, load_plan
from tiloilc.label import Labeller
from tiloilc.plan import Plan, importable
from tiloilc.product import Walk, walk_tables

NAMES = ("best", "last", "cloning")
"""The policies of a run: each seed's best by validation, at the end, after cloning alone."""


@dataclass(eq=False)
class Policy:
    """One trained agent, greedy and without randomness. `state` is where its automaton is.

    Call `reset` when an episode begins and `act` once for each observation, the first one
    included. It belongs to one environment: its automaton is in one state. `visits` counts the
    accepting states that steps of this episode led to.
    """

    plan: Plan = field(repr=False)
    seed: int
    actor: Actor = field(repr=False)
    labels: Labeller = field(repr=False)
    walk: Walk = field(repr=False)
    state: int = -1
    visits: int = 0

    def __post_init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """An episode begins: no label has been read."""
        self._begins, self.state, self.visits = True, self.walk.initial, 0

    def act(self, observation: object) -> Any:
        """Read the label of `observation` and step the automaton; then the action.

        A dictionary is taken where its values are arrays. Where one of them is a choice
        (`Discrete`) or the task file names parts of observations by itself, ValueError says what
        to give. Raises ValueError also for another number of numbers, for what is not finite, and
        for a place that the table of a finite task does not have.
        """
        flat = self.observe(observation)
        return self.actor.act(flat, np.array([self.state]))[0]

    def observe(self, observation: object) -> Floats:
        """Only read the label and step, as for the last observation of an episode.

        Where the automaton offers ε-jumps it goes where arriving is worth most. Returns the
        observation as it was read, flat [1, d].
        """
        flat = self._flat(observation)
        options = self.walk.options[self.state, int(self.labels(flat)[0])]
        best = 0
        if (options != options[0]).any():
            values = self.actor.values(flat.repeat(len(options), axis=0), options)
            best = int(values.argmax())
        self.state = int(options[best])
        self.visits += self.accepting and not self._begins
        self._begins = False
        return flat

    @property
    def accepting(self) -> bool:
        """Whether the automaton is in an accepting state."""
        return bool(self.walk.accepting[self.state])

    @property
    def lost(self) -> bool:
        """Whether the formula can no longer be satisfied."""
        return self.state == self.walk.sink

    def _flat(self, observation: object) -> Floats:
        """[1, d]; of a dictionary, each key stands where the plan's field of that name does."""
        if isinstance(observation, Mapping):
            observation = self._joined(observation)
        flat = np.asarray(observation, dtype=np.float32).reshape(1, -1)
        given, read = flat.size, self.actor.dimensions
        if given != read:
            numbers = "1 number" if given == 1 else f"{given} numbers"
            raise ValueError(f"an observation of {numbers}, the policy reads {read}")
        if not np.isfinite(flat).all():
            raise ValueError("an observation with entries that are not finite numbers")
        low, high = self.actor.limits
        if (flat < low).any() or (flat > high).any():
            first, last = (ends.tolist() if read > 1 else ends[0] for ends in (low, high))
            raise ValueError(f"an observation outside {first}…{last}")
        return flat

    def _joined(self, observation: Mapping[str, object]) -> Floats:
        """The arrays of a dictionary, each in its place. Raises ValueError if that is not known."""
        fields = self.plan.fields
        given = {k: np.asarray(v, np.float32).reshape(-1) for k, v in observation.items()}
        sizes = {name: stop - start for name, (start, stop) in fields.items()}
        shown = {name: len(value) for name, value in given.items()}
        if shown != sizes:
            hint = "give flatten(env.observation_space, observation) of gymnasium.spaces.utils"
            raise ValueError(f"an observation of the sizes {shown} does not fill {sizes}: {hint}")
        flat = np.empty(max(stop for _, stop in fields.values()), dtype=np.float32)
        for name, (start, stop) in fields.items():
            flat[start:stop] = given[name]
        return flat


def usual_policy(run: Path) -> str:
    """The policy of a run that is meant where none is named: the best by validation, or the last
    where nothing was validated."""
    return "best" if (run / "checkpoints/best.safetensors").is_file() else "last"


def load_policy(run: str | Path, *, seed: int | None = None, policy: str | None = None) -> Policy:
    """The policy of one agent that the run in the folder `run` left.

    `policy` is one of NAMES; without it, the usual one. `seed` is one of the run's seeds; without
    it, the one that did best in validation. Raises CompileError RUN706 if the run is not finished,
    RUN708 if it has no such policy or the policy cannot act alone, RUN701 if it cannot be read.
    """
    run = Path(run)
    plan = load_plan(run, of_run=True)
    policy = policy or usual_policy(run)
    arrays = _read(run, policy)
    first, count = plan.train.first_seed, plan.train.seeds
    walk = walk_tables(plan.ldba, plan.train.epsilon)
    if walk.costly:
        problem = "with `epsilon: step` its jumps are chosen by discriminators"
        raise _unavailable(run, problem)
    if seed is None:
        scores = arrays["scores"]
        seed = first + max(range(count), key=lambda i: (*scores[i].tolist(), -i))
    if not first <= seed < first + count:
        raise _unavailable(run, f"it has the seeds {first} to {first + count - 1}, not {seed}")
    acting = {k: v for k, v in arrays.items() if k != "scores"}
    try:
        actor = actor_of(acting, count, seed - first, plan.train.layer_norm)
    except KeyError as error:
        problem = f"{policy}.safetensors has no {error}: another version wrote it"
        raise CompileError(Diagnostic.of("RUN701", path=run.as_posix(), problem=problem)) from None
    with importable(plan.root):
        return Policy(plan, seed, actor, labeller(plan), walk)


def _read(run: Path, policy: str) -> dict[str, NDArray[Any]]:
    from safetensors import SafetensorError
    from safetensors.numpy import load_file

    folder = run / "checkpoints"
    if not (folder / "last.safetensors").is_file():
        help = f"tiloilc train {run.as_posix()} --resume"
        raise CompileError(Diagnostic.of("RUN706", help=help, path=run.as_posix()))
    path = folder / f"{policy}.safetensors"
    if policy not in NAMES or not path.is_file():
        there = [name for name in NAMES if (folder / f"{name}.safetensors").is_file()]
        raise _unavailable(run, f"it has {' and '.join(f'`{n}`' for n in there)}, no `{policy}`")
    try:
        return load_file(path)
    except (OSError, SafetensorError):
        problem = f"{path.name} is damaged"
        raise CompileError(Diagnostic.of("RUN701", path=run.as_posix(), problem=problem)) from None


def _unavailable(run: Path, problem: str) -> CompileError:
    return CompileError(Diagnostic.of("RUN708", path=run.as_posix(), problem=problem))
