"""Every way to translate, read off the signature of `translate`: a new choice is tested at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from inspect import signature
from typing import Literal, cast, get_args, get_origin, get_type_hints

from tiloilc.automaton import Ldba, translate
from tiloilc.ltl.ast import Formula

Translation = Callable[[Formula, Sequence[str]], Ldba]


def variants() -> dict[str, Translation]:
    """The default, and for every keyword with fixed choices each choice that is not the default."""
    found: dict[str, Translation] = {"default": cast(Translation, translate)}
    hints = get_type_hints(translate)
    for name, parameter in signature(translate).parameters.items():
        if get_origin(hints[name]) is Literal:
            for choice in get_args(hints[name]):
                if choice != parameter.default:
                    run = partial(translate, **{name: choice})
                    found[f"{name} {choice}"] = cast(Translation, run)
    return found
