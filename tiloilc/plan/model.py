"""The plan: everything a training job needs, resolved and frozen (contract, section 3)."""

from __future__ import annotations

from dataclasses import dataclass

from tiloilc.automaton.ldba import Ldba
from tiloilc.spec.model import Demonstrations, Environment, Evaluate
from tiloilc.spec.settings import Settings

SCHEMA_VERSION = 1


@dataclass(frozen=True, slots=True)
class Stages:
    """The stages of an automaton's states, each tuple indexed by state (paper, section 3.2).

    `index[b]` is SIDX(b) and `length[b]` is N(b), both in edges; `distance[b]` is the number of
    edges to the nearest accepting state, -1 in the sink. `positive[b]` and `negative[b]` name the
    stage buffers that feed discriminator f_b: a state's number, or `sink_buffer` for B_⊥. They are
    empty for accepting states and the sink, which have no discriminator.
    """

    index: tuple[int, ...]
    length: tuple[int, ...]
    distance: tuple[int, ...]
    positive: tuple[tuple[int, ...], ...]
    negative: tuple[tuple[int, ...], ...]

    @property
    def sink_buffer(self) -> int:
        """The number of B_⊥, after those of all states."""
        return len(self.index)


@dataclass(frozen=True, slots=True)
class Predicate:
    """How one proposition is computed: `text` in the predicate language, or `file:function`."""

    name: str
    text: str = ""
    python: str = ""


@dataclass(frozen=True, slots=True)
class Plan:
    """A compiled task. `fields` are the named slices [start, stop) of the flat observation.

    `digests` are sha256 of what the plan was compiled from: `demos.npz` stands beside the plan, the
    others are named by kind and path relative to `root`, as in `spec:task.yaml`,
    `automaton:mine.hoa`, `python:labels.py`, `demonstrations:mine.npz`. `formula` is empty where
    the task file names an automaton instead. `root` is the folder of the task file, absolute
    in memory and relative to the plan in a file; it is no part of the plan's own digest. `python:`
    predicates and the modules of own environments are found there.
    """

    name: str
    description: str
    environment: Environment
    fields: dict[str, tuple[int, int]]
    predicates: tuple[Predicate, ...]
    formula: str
    ldba: Ldba
    stages: Stages
    demonstrations: Demonstrations
    train: Settings
    evaluate: Evaluate
    digests: dict[str, str]
    version: str
    schema_version: int = SCHEMA_VERSION
    root: str = ""

    @property
    def goal(self) -> str:
        """What is asked for: the formula, or the file of the automaton that stands for it."""
        files = (key.partition(":")[2] for key in self.digests if key.startswith("automaton:"))
        return self.formula or next(files, "")
