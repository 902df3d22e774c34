"""The update as one compiled program, where that pays and a compiler is to be had."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress
from types import FunctionType
from typing import Any, Generic, ParamSpec, TypeVar, cast

import torch

from tiloilc.learn.engine.products import build
from tiloilc.spec.settings import Settings

P = ParamSpec("P")
R = TypeVar("R")

MANY_UPDATES = 25_000
"""From here on compiling pays: it takes 40 seconds of processor time, and each update then takes
about two milliseconds less."""

Say = Callable[[str], None]


def pays(settings: Settings) -> bool:
    """Whether the update is to be compiled: as the setting says, or by the number of updates."""
    steps = settings.steps - settings.learning_starts
    many = steps * settings.updates_per_step >= MANY_UPDATES
    return settings.compile == "always" or (settings.compile == "auto" and many)


class Program(Generic[P, R]):
    """A function that changes tensors in place, compiled at its first call if `compiled`.

    A compiled program looks at each call whether what it was compiled for still holds, which takes
    a tenth of an update. It is `settled` when nothing but values of tensors ever changes: then it
    does not look.

    What cannot be compiled here (there is no C++ compiler, the platform has no support) is called
    as it is, and one line says so. Sums come out differently in their last digits when compiled, so
    a run that goes on stays with what it began with: `compiled` belongs to its state.
    """

    def __init__(self, function: Callable[P, R], compiled: bool, settled: bool, say: Say) -> None:
        self.function, self.compiled, self.say = function, compiled, say
        self.options: dict[str, Any] = {"cpp_wrapper": True}
        if settled:
            self.options["guard_filter_fn"] = torch.compiler.skip_all_guards_unsafe
        self._call: Callable[P, R] | None = None

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Call it."""
        if not self.compiled:
            return self.function(*args, **kwargs)
        if self._call is not None:
            return self._call(*args, **kwargs)
        self.say("compiling the update, which takes a minute and makes each faster")
        with suppress(Exception):  # torch multiplies then; what is amiss is said below
            build()
        try:
            call: Callable[P, R] = torch.compile(
                _apart(self.function), fullgraph=True, dynamic=False, options=self.options
            )
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # the compiler's, about its own parts
                result = call(*args, **kwargs)
        except Exception as error:  # whatever goes wrong in a compiler, there is another way
            lines = (line for line in str(error).splitlines() if line.strip(": "))
            why = next((line for line in lines if not line.endswith(":")), type(error).__name__)
            self.say(f"training goes on slower, the update cannot be compiled here: {why.strip()}")
            self.compiled = False
            return self.function(*args, **kwargs)
        self._call = call
        return result


def _apart(function: Callable[P, R]) -> Callable[P, R]:
    """The same function with code of its own.

    torch keeps what it compiled with the code. A program that does not look whether it still holds
    would be taken for another agent's that runs the same code with other settings.
    """
    inner: Any = getattr(function, "__func__", function)
    code, names = inner.__code__.replace(), inner.__globals__
    apart = FunctionType(code, names, inner.__name__, inner.__defaults__, inner.__closure__)
    owner = getattr(function, "__self__", None)
    return cast("Callable[P, R]", apart if owner is None else apart.__get__(owner))
