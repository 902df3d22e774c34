"""Experts that a user writes: a function `file.py:function` that begins an episode.

It is called once an episode with a `numpy.random.Generator`, and returns what acts in it: from an
observation to an action, or to None when nothing is left to do. What it remembers, it keeps in
between, as closures and objects do:

    def swing(generator):
        def act(observation):
            return [1.0 if observation[1] > 0 else -1.0]
        return act
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.tasks import Progress
from tiloilc.userfile import Unusable, meant, named, run_file

if TYPE_CHECKING:
    import gymnasium
    from gymnasium.spaces import Discrete

Acts = Callable[[Any], object]


@dataclass(frozen=True, slots=True)
class Playing(Progress):
    """Progress of an episode, and what acts in it."""

    acts: Acts | None = None


@dataclass(frozen=True, eq=False)
class FunctionExpert:
    """What a user's function does, in actions of `space`.

    With `noise`, each component of an action is disturbed by up to that share of half its range;
    of numbered actions that share is drawn at random.
    """

    name: str
    function: Callable[[np.random.Generator], object]
    space: gymnasium.Space[Any]
    noise: float = 0.0
    laps: int = 0

    def begin(self, observation: object, generator: np.random.Generator) -> Playing:
        """Ask the function what is to act in this episode."""
        try:
            acts = self.function(generator)
        except (Exception, SystemExit) as error:
            raise _unusable(self.name, _raised(error)) from error
        if not callable(acts):
            help = "return a function from observations to actions"
            raise _unusable(self.name, f"it returned {type(acts).__name__}, which cannot act", help)
        return Playing(acts=acts)

    def act(
        self, observation: object, progress: Progress, generator: np.random.Generator
    ) -> tuple[NDArray[Any], Progress]:
        """The next action, disturbed."""
        assert isinstance(progress, Playing)
        assert progress.acts is not None
        try:
            wanted = progress.acts(observation)
        except (Exception, SystemExit) as error:
            raise _unusable(self.name, _raised(error)) from error
        if wanted is None:
            return np.zeros(self.space.shape or ()), Playing(acts=progress.acts, done=True)
        return self._disturbed(self._action(wanted), generator), progress

    def _action(self, wanted: object) -> NDArray[Any]:
        from gymnasium.spaces import Discrete

        if isinstance(self.space, Discrete):
            return self._numbered(wanted, self.space)
        shape = self.space.shape or ()
        try:
            action: NDArray[Any] = np.asarray(wanted, self.space.dtype).reshape(shape)
            if np.isfinite(action).all():
                return action
        except (TypeError, ValueError):
            pass
        problem = f"it returned {wanted!r}, which is no action of shape {list(shape)}"
        raise _unusable(self.name, problem)

    def _numbered(self, wanted: object, space: Discrete) -> NDArray[Any]:
        first, last = int(space.start), int(space.start + space.n - 1)
        try:
            given = np.asarray(wanted).reshape(())
            if (number := int(given)) == given and first <= number <= last:
                return np.asarray(number, space.dtype)
        except (TypeError, ValueError, OverflowError):
            pass
        problem = f"it returned {wanted!r}, which is none of the actions {first} to {last}"
        raise _unusable(self.name, problem)

    def _disturbed(self, action: NDArray[Any], generator: np.random.Generator) -> NDArray[Any]:
        from gymnasium.spaces import Box, Discrete

        if isinstance(self.space, Discrete):
            other = generator.integers(self.space.n) + self.space.start
            return np.asarray(other if generator.random() < self.noise else action)
        assert isinstance(self.space, Box), "other actions cannot be learned"
        low, high = self.space.low.astype(float), self.space.high.astype(float)
        push = self.noise * generator.uniform(-1.0, 1.0, action.shape) * (high - low) / 2
        disturbed: NDArray[Any] = np.clip(action + push, low, high).astype(self.space.dtype)
        return disturbed


def function_expert(reference: str, space: gymnasium.Space[Any]) -> FunctionExpert:
    """The expert that `file.py:function` names. The file is executed.

    Raises CompileError DEMO509 if there is no such function.
    """
    path, _, name = reference.rpartition(":")
    if not path.endswith(".py") or not name.isidentifier():
        help = f"name its function too: `{reference}:FUNCTION`" if name.endswith(".py") else ""
        raise _unusable(reference, "it is not `file.py:function`", help)
    return FunctionExpert(reference, _load(reference, Path(path), name), space)


def _load(reference: str, path: Path, name: str) -> Callable[[np.random.Generator], object]:
    try:
        module = run_file(path)
    except Unusable as error:
        raise _unusable(reference, str(error)) from error
    function: object = getattr(module, name, None)
    if not callable(function):
        problem = f"the file has no function `{name}`"
        raise _unusable(reference, problem, meant(module, name))
    return function


def _raised(error: BaseException) -> str:
    return f"it raised {named(error)}"


def _unusable(reference: str, problem: str, help: str = "") -> CompileError:
    return CompileError(Diagnostic.of("DEMO509", reference=reference, problem=problem, help=help))
