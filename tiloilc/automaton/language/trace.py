"""An automaton walked letter by letter, with every choice kept, so that one can go back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import lcm

from tiloilc.automaton.language.words import accepting_lasso
from tiloilc.automaton.ldba import Ldba, Letter, StateId
from tiloilc.ltl import Lasso


@dataclass(frozen=True, slots=True)
class Step:
    """One letter read in `source`, with all states that it could lead to, and the one it did."""

    letter: Letter
    source: StateId
    options: tuple[StateId, ...]
    state: StateId


@dataclass(frozen=True)
class Trace:
    """A run so far. Acceptance is that of states."""

    ldba: Ldba
    steps: tuple[Step, ...] = ()

    def __post_init__(self) -> None:
        assert not self.ldba.accepting_edges, "walked are automata with accepting states"

    @property
    def state(self) -> StateId:
        """Where the run is."""
        return self.steps[-1].state if self.steps else self.ldba.initial

    @property
    def visits(self) -> int:
        """How many of the states after a letter were accepting."""
        return sum(step.state in self.ldba.accepting for step in self.steps)

    @property
    def lost(self) -> bool:
        """Whether the run is in the sink."""
        return self.state == self.ldba.sink

    def options(self, letter: Letter) -> tuple[StateId, ...]:
        """Where `letter` may lead: δ's target first, then by each jump."""
        return self.ldba.options(self.state, letter)

    def read(self, letter: Letter, to: StateId | None = None) -> Trace:
        """The run after one more letter: to its first option, or to `to`, one of them."""
        options = self.options(letter)
        target = options[0] if to is None else to
        assert target in options, f"{target} is none of {options}"
        return Trace(self.ldba, (*self.steps, Step(letter, self.state, options, target)))

    def back(self) -> Trace:
        """The run before the last letter; at the start nothing changes."""
        return Trace(self.ldba, self.steps[:-1])

    def follow(self, letters: Sequence[Letter], states: Sequence[StateId]) -> Trace:
        """The run after `letters`, by `states`."""
        run = self
        for letter, state in zip(letters, states, strict=True):
            run = run.read(letter, state)
        return run


def accepting_run(ldba: Ldba, word: Lasso) -> tuple[tuple[StateId, ...], int] | None:
    """The states after each letter of an accepting run on `word`, and where its repetition begins.

    The states up to the end of the first repetition; None if no run accepts.
    """
    letters, back = word.letters, len(word.stem)

    def moves(place: tuple[StateId, int]) -> Iterator[tuple[tuple[StateId, int], bool, int]]:
        state, position = place
        if state == ldba.sink:
            return
        following = position + 1 if position + 1 < len(letters) else back
        for target in ldba.options(state, letters[position]):
            yield (target, following), target in ldba.accepting, target

    found = accepting_lasso((ldba.initial, 0), moves)
    if found is None:
        return None
    begin = max(len(word.stem), len(found.stem))
    around = lcm(len(word.loop), len(found.loop))
    return tuple(_unrolled(found, begin + around)), begin


def unrolled(word: Lasso, count: int) -> tuple[Letter, ...]:
    """The first `count` letters of `word`."""
    return tuple(_unrolled(word, count))


def _unrolled(word: Lasso, count: int) -> Iterator[int]:
    for i in range(count):
        beyond = i - len(word.stem)
        yield word.stem[i] if beyond < 0 else word.loop[beyond % len(word.loop)]
