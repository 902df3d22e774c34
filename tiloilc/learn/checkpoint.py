"""Checkpoints: one safetensors file for everything, committed by a small JSON pointer."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path

from safetensors.torch import load, save

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.state import State

LAST, PREVIOUS = "last.json", "previous.json"


@dataclass(frozen=True, slots=True)
class Pointer:
    """What a checkpoint is of: its data file, that file's digest, and where the events stood."""

    file: str
    sha256: str
    step: int
    events_bytes: int
    plan_digest: str


def save_checkpoint(
    folder: Path, state: State, step: int, events_bytes: int, plan_digest: str
) -> None:
    """Write a checkpoint; a crash at any moment leaves the one before readable.

    Raises CompileError RUN703 when it cannot be written (a full disk); what was there stays.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        data = save({k: v.detach().contiguous() for k, v in sorted(state.items())})
        name = f"{step:010d}.safetensors"
        replace_file(folder / name, data)
        pointer = Pointer(name, hashlib.sha256(data).hexdigest(), step, events_bytes, plan_digest)
        if (folder / LAST).is_file():
            replace_file(folder / PREVIOUS, (folder / LAST).read_bytes())
        replace_file(folder / LAST, _dump(pointer))
    except OSError as error:
        help = "free some space and go on with --resume"
        problem = (error.strerror or str(error)).lower()
        raise CompileError(
            Diagnostic.of("RUN703", help=help, path=folder.as_posix(), problem=problem)
        ) from None
    _prune(folder)


def load_checkpoint(folder: Path, plan_digest: str) -> tuple[State, Pointer, str | None]:
    """The newest checkpoint that is whole, and why a newer one was not used, if so.

    Raises CompileError RUN701 if there is none, RUN704 if it is of another plan.
    """
    problems = []
    for name in (LAST, PREVIOUS):
        try:
            pointer = Pointer(**json.loads((folder / name).read_text(encoding="utf-8")))
            data = (folder / pointer.file).read_bytes()
            if hashlib.sha256(data).hexdigest() != pointer.sha256:
                raise ValueError(f"{pointer.file} is damaged")
        except FileNotFoundError as error:
            problems.append(f"{Path(str(error.filename)).name} is missing")
        except (OSError, ValueError, TypeError) as error:
            problems.append(str(error))
        else:
            if pointer.plan_digest != plan_digest:
                raise CompileError(Diagnostic.of("RUN704", path=folder.parent.as_posix()))
            if problems:  # the damaged one must not become `previous` with the next save
                replace_file(folder / LAST, (folder / name).read_bytes())
            return load(data), pointer, problems[0] if problems else None
    raise CompileError(
        Diagnostic.of("RUN701", path=folder.parent.as_posix(), problem="; ".join(problems))
    )


def replace_file(path: Path, data: bytes) -> None:
    """Write `path` under a temporary name, flush it to the disk and rename."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with temporary.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def _dump(pointer: Pointer) -> bytes:
    fields = {name: getattr(pointer, name) for name in Pointer.__slots__}
    return (json.dumps(fields, indent=1, sort_keys=True) + "\n").encode()


def _prune(folder: Path) -> None:
    """Remove the data files that no pointer names."""
    kept = set()
    for name in (LAST, PREVIOUS):
        with contextlib.suppress(OSError, ValueError, KeyError):
            kept.add(json.loads((folder / name).read_text(encoding="utf-8"))["file"])
    for path in folder.glob("[0-9]*.safetensors"):
        if path.name not in kept:
            path.unlink(missing_ok=True)
