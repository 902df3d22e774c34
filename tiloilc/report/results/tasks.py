"""The tasks as results speak of them: their titles, their order, and what their files ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from tiloilc.report.results.methods import METHODS
from tiloilc.spec import Settings, read_spec
from tiloilc.spec.presets import PRESETS

__all__ = ["FIGURE_3", "GRIDS", "ROBOTS", "TITLES", "TaskFile", "read_tasks", "title"]

TITLES = {
    "grid_avoid_easy": "GridAvoid Easy",
    "grid_avoid_medium": "GridAvoid Medium",
    "grid_avoid_hard": "GridAvoid Hard",
    "grid_sequential_easy": "GridSequential Easy",
    "grid_sequential_medium": "GridSequential Medium",
    "grid_sequential_hard": "GridSequential Hard",
    "grid_circular_easy": "GridCircular Easy",
    "grid_circular_medium": "GridCircular Medium",
    "grid_circular_hard": "GridCircular Hard",
    "flatworld_stabilization": "FlatWorld Stabilization",
    "flatworld_cycle": "FlatWorld Cycle",
    "flatworld_disjunction": "FlatWorld Disjunction",
    "carlo": "Carlo",
    "doggo_avoid": "Doggo Avoid",
    "doggo_navigate": "Doggo Navigate",
    "fetch_avoid": "Fetch Avoid",
    "fetch_align": "Fetch Align",
    "fetchplace_tray": "FetchPlace Tray",
    "fetchplace_button": "FetchPlace Button",
    "cheetah_flip": "Cheetah Flip",
    "sixteen_rooms": "SixteenRooms",
    "sixteen_rooms_prose": "SixteenRooms (by its text)",
}
"""Every task in the order of the paper; of another one the name is its title."""

GRIDS = tuple(name for name in TITLES if name.startswith("grid_"))
"""The nine of figure 5."""

ROBOTS = tuple(name for name in TITLES if name.startswith(("doggo_", "fetch", "cheetah_")))

FIGURE_3 = (
    "grid_circular_hard",
    "flatworld_stabilization",
    "flatworld_cycle",
    "doggo_avoid",
    "fetch_avoid",
    "carlo",
    "doggo_navigate",
    "fetch_align",
    "cheetah_flip",
    "fetchplace_tray",
    "fetchplace_button",
    "sixteen_rooms",
)


@dataclass(frozen=True)
class TaskFile:
    """What a task file asks for: its settings of training, and its demonstrations by key."""

    name: str
    train: Settings
    demonstrations: Mapping[str, object]

    def defaults(self, preset: str, algorithm: str) -> dict[str, object]:
        """What a run of the file with this preset and method sets apart from what these bring."""
        known = self._of_methods.get((preset, algorithm))
        return self._apart(preset, algorithm) if known is None else known

    @cached_property
    def _of_methods(self) -> dict[tuple[str, str], dict[str, object]]:
        return {(p, a): self._apart(p, a) for p in PRESETS for a in METHODS}

    def _apart(self, preset: str, algorithm: str) -> dict[str, object]:
        return self.train.override({"preset": preset, "algorithm": algorithm}).overrides()


def read_tasks(folder: Path) -> dict[str, TaskFile]:
    """The task files of a folder by the name of their task."""
    found = {}
    for path in sorted(folder.glob("*.yaml")):
        spec = read_spec(path).spec
        given = spec.demonstrations
        shown = {} if given is None else given.model_dump(mode="json", exclude_none=True)
        found[spec.name] = TaskFile(spec.name, spec.train, shown)
    return found


def title(task: str) -> str:
    """As the paper writes it."""
    return TITLES.get(task, task)
