"""Demonstrations as settings: what a command or a sweep lays over a task file's own."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.spec.model import Demonstrations

PREFIX = "demonstrations."
"""What the names of these settings begin with, beside those of training."""

DEMO_FIELDS = MappingProxyType({PREFIX + key: f for key, f in Demonstrations.model_fields.items()})
"""The keys of `demonstrations` as settings."""

DEMO_FILE = PREFIX + "file"

ORIGINS = (PREFIX + "source", DEMO_FILE, PREFIX + "minari")
"""Where demonstrations come from: each takes the place of the others."""


@dataclass(frozen=True)
class Laid:
    """Settings of demonstrations, and where each is given; None: on the command line.

    A relative file is from the working folder.
    """

    values: Mapping[str, object] = field(default_factory=dict)
    places: Mapping[str, Span | None] = field(default_factory=dict)

    def over(self, own: Demonstrations | None, folder: Path) -> Demonstrations:
        """A task file's demonstrations with these; `folder` is the task file's.

        Raises CompileError SPEC108 where neither says where they come from.
        """
        given = {} if own is None else dotted(own, defaults=False)
        values = {**beside(given, self.values), **self.values}
        if all(values.get(origin) is None for origin in ORIGINS):
            names = [f"`{name}`" for name in ORIGINS]
            problem = f"`demonstrations` needs one of {', '.join(names[:-1])} and {names[-1]}"
            help = f"set one, as in `{ORIGINS[0]}: expert`"
            place = next(iter(self.places.values()), None)
            raise CompileError(Diagnostic.of("SPEC108", place, problem=problem, help=help))
        if DEMO_FILE in self.values:
            values[DEMO_FILE] = seen_from(folder, Path(str(self.values[DEMO_FILE])), Path())
        return Demonstrations.model_validate(
            {name.removeprefix(PREFIX): value for name, value in values.items()}
        )

    def place(self, kind: str, otherwise: Span) -> Span | None:
        """Where demonstrations are given that come from `kind`: here, as far as here is anything.

        What is not given here stands `otherwise` in the task file.
        """
        if PREFIX + kind in self.places:
            return self.places[PREFIX + kind]
        return next(iter(self.places.values()), otherwise)


NOTHING = Laid()
"""A task as its file says."""


def dotted(given: Demonstrations, defaults: bool = True) -> dict[str, object]:
    """A task's demonstrations as settings, without what is nothing; with what it does not say."""
    values = given.model_dump(mode="json", exclude_none=True, exclude_unset=not defaults)
    return {PREFIX + key: value for key, value in values.items()}


def beside(settings: Mapping[str, object], others: Iterable[str]) -> dict[str, object]:
    """The settings but for origins of demonstrations that one among the `others` replaces."""
    names = set(others)
    gone = set(ORIGINS) - names if names & set(ORIGINS) else set()
    return {name: value for name, value in settings.items() if name not in gone}


def exclusive(names: Iterable[str]) -> Iterator[tuple[int, int]]:
    """Which of the names, by their positions, cannot be given together."""
    listed = [ORIGINS if name in ORIGINS else name for name in names]
    for first, one in enumerate(listed):
        for second in range(first + 1, len(listed)):
            if listed[second] == one:
                yield first, second


def seen_from(folder: Path, file: Path, home: Path) -> str:
    """A file, named as in the folder `home`, as one in `folder` names it; an absolute path stays.

    However the folders themselves are named, the same file has the same name.
    """
    if file.is_absolute():
        return file.as_posix()
    place = (home / file).parent.resolve() / file.name
    return Path(os.path.relpath(place, folder.resolve())).as_posix()
