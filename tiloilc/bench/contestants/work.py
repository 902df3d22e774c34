"""The work that contestants do: the same networks, the same batches, the same tasks."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias

import tiloilc.specs

Run: TypeAlias = Callable[[int], None]
"""Does so many pieces of the work: updates, or environment steps."""

WARM_UP = 1_000
"""Environment steps of random actions before learning, so that buffers have something in them."""


@dataclass(frozen=True, slots=True)
class Work:
    """What to do it with. The networks are those of the paper's Table 5 unless told otherwise.

    `task` is the name of a task file, here or in `specs/`, `threads` says that it takes place on
    all cores, and is timed by the clock, `needs` are the modules without which
    its environment cannot be made.
    """

    task: str = "noise"
    seeds: int = 1
    copies: int = 1
    batch: int = 64
    actor: tuple[int, ...] = (256, 256, 256)
    critic: tuple[int, ...] = (256, 256)
    discriminators: bool = False
    compiled: bool = True
    threads: bool = False
    needs: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        """The task file."""
        own = Path(__file__).with_name(f"{self.task}.yaml")
        return own if own.is_file() else Path(tiloilc.specs.__path__[0]) / own.name

    def to_json(self) -> str:
        """For the command line."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Work:
        """What `to_json` gave."""
        fields: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in json.loads(text).items()
        }
        return cls(**fields)
