"""A compiled task as it travels to a machine that has no files in common with this one."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from tiloilc.driver import plan_file, read_plan, write_plan
from tiloilc.writing import write_file

NEEDED = ("python", "environment")
"""Kinds of inputs that training reads itself, beside the build."""


@dataclass(frozen=True)
class Parcel:
    """The files of a build folder, and the user's files that its plan needs, by their paths."""

    build: Mapping[str, bytes]
    inputs: Mapping[str, bytes]


def pack(build: Path) -> Parcel:
    """All that a job needs of a build folder and of the task file's folder."""
    plan = read_plan(build)
    names = [key.partition(":")[2] for key in plan.digests if key.partition(":")[0] in NEEDED]
    return Parcel(
        {path.name: path.read_bytes() for path in sorted(build.iterdir()) if path.is_file()},
        {name: (Path(plan.root) / name).read_bytes() for name in names},
    )


def unpack(parcel: Parcel, build: Path, folder: Path) -> Path:
    """The build folder: `build` itself where this machine has it, else one in `folder`."""
    plan = plan_file(build)
    if plan.is_file() and plan.read_bytes() == parcel.build[plan.name]:
        return build
    ours, inputs = folder / "build", folder / "inputs"
    for place, files in ((inputs, parcel.inputs), (ours, parcel.build)):
        place.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            write_file(place / name, content)
    write_plan(dataclasses.replace(read_plan(ours), root=str(inputs.resolve())), plan_file(ours))
    return ours
