"""Checkpoints: safetensors files, committed by a small JSON pointer that names them all.

A checkpoint is a file of everything, and files of what was written to replay and stage buffers.
Those are large and hardly change from one checkpoint to the next, so each adds only the new rows:
not to the files of the last checkpoint but of the one before it. The last two share no file, so
that no single damage can take both.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import TracebackType

import torch
from pydantic import BaseModel, ConfigDict, ValidationError
from safetensors.torch import load_file, save
from torch import Tensor

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.engine.state import State

LAST, PREVIOUS = "last.json", "previous.json"

WASTE = 2
"""Rows in files for each row that is still in its ring, before all are written afresh."""

SCHEMA_VERSION = 4
"""Of what tensors there are in a checkpoint, and of the pointer."""

Written = dict[str, list[int]]
"""How many rows each ring was ever given, by name."""


class File(BaseModel):
    """A file beside the pointer, and what is in it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    sha256: str


class Rows(File):
    """The rows that were new when the rings had been `written` so often."""

    written: Written


class Pointer(BaseModel):
    """What a checkpoint is of, and its files; `events_bytes` is where the event log stood."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    schema_version: int
    step: int
    seconds: float
    events_bytes: int
    plan_digest: str
    state: File
    rows: tuple[Rows, ...]


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A whole checkpoint; `problem` says why a newer one was not used, if so."""

    folder: Path
    pointer: Pointer
    problem: str | None

    def state(self) -> State:
        """Everything but the rows of rings."""
        return load_file(self.folder / self.pointer.state.name)

    def restore(self, rings: Mapping[str, Ring]) -> None:
        """Put the rows back into their rings."""
        before = _nothing(rings)
        for part in self.pointer.rows:
            rows = load_file(self.folder / part.name)
            for name, ring in rings.items():
                ring.restore(rows[name], *(torch.tensor(w[name]) for w in (before, part.written)))
            before = part.written


class Checkpoints:
    """Writes the checkpoints of one run, in a thread of its own while training goes on.

    A crash at any moment leaves the last whole checkpoint readable. What goes wrong in the thread
    (a full disk) is raised as CompileError RUN703 by the next call; what was there stays.
    """

    def __init__(self, folder: Path, plan_digest: str, resumed: Checkpoint | None = None) -> None:
        self.folder, self.plan_digest = folder, plan_digest
        self._last = resumed.pointer.rows if resumed is not None else ()
        self._before_last: tuple[Rows, ...] = ()  # whether its files are whole is not known
        self._thread = ThreadPoolExecutor(1, "checkpoint")
        self._writing: Future[tuple[Rows, ...]] | None = None

    def save(
        self,
        state: Mapping[str, Tensor],
        rings: Mapping[str, Ring],
        step: int,
        seconds: float,
        events_bytes: int,
        sync: Callable[[], None] = lambda: None,
    ) -> None:
        """Copy what is to be written, and begin to write it; `sync` runs before anything else.

        Waits while the checkpoint before is still being written.
        """
        self.wait()
        base = _worth_keeping(self._before_last, rings)
        before = base[-1].written if base else _nothing(rings)
        new = {name: ring.since(torch.tensor(before[name])).cpu() for name, ring in rings.items()}
        copied = {name: _copy(tensor) for name, tensor in sorted(state.items())}
        written = {name: ring.written.tolist() for name, ring in rings.items()}

        def write() -> tuple[Rows, ...]:
            try:
                sync()
                self.folder.mkdir(parents=True, exist_ok=True)
                rows = base
                if new:
                    file = _write_tensors(self.folder, f"{step:010d}.rows", new)
                    rows += (Rows(**file.model_dump(), written=written),)
                file = _write_tensors(self.folder, f"{step:010d}", copied)
                pointer = Pointer(
                    schema_version=SCHEMA_VERSION,
                    step=step,
                    seconds=seconds,
                    events_bytes=events_bytes,
                    plan_digest=self.plan_digest,
                    state=file,
                    rows=rows,
                )
                if (self.folder / LAST).is_file():
                    replace_file(self.folder / PREVIOUS, (self.folder / LAST).read_bytes())
                replace_file(
                    self.folder / LAST, (pointer.model_dump_json(indent=1) + "\n").encode()
                )
                _prune(self.folder)
            except OSError as error:
                raise not_written(self.folder, error) from None
            return rows

        self._writing = self._thread.submit(write)

    def check(self) -> None:
        """Raise what went wrong, without waiting."""
        if self._writing is not None and self._writing.done():
            self.wait()

    def wait(self) -> None:
        """Until the checkpoint is written."""
        if self._writing is not None:
            writing, self._writing = self._writing, None
            self._last, self._before_last = writing.result(), self._last

    def __enter__(self) -> Checkpoints:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._thread.shutdown()
        if error is None:
            self.wait()


def load_checkpoint(folder: Path, plan_digest: str) -> Checkpoint | None:
    """The newest checkpoint that is whole, None if none was ever written.

    Raises CompileError RUN701 if there is none that is whole, RUN704 if it is of another plan,
    RUN712 if another version of tiloilc wrote it.
    """
    if not any((folder / name).is_file() for name in (LAST, PREVIOUS)):
        return None
    problems = []
    for name in (LAST, PREVIOUS):
        try:
            data = (folder / name).read_bytes()
            if _is_of_another_version(data):
                help = "go on with that version; `plan.json` in the folder of the run says which"
                run = folder.parent.as_posix()
                raise CompileError(Diagnostic.of("RUN712", help=help, path=run))
            pointer = Pointer.model_validate_json(data)
            for file in (pointer.state, *pointer.rows):
                with (folder / file.name).open("rb") as content:
                    if hashlib.file_digest(content, "sha256").hexdigest() != file.sha256:
                        raise ValueError(f"{file.name} is damaged")
        except ValidationError:
            problems.append(f"{name} is damaged")
        except FileNotFoundError as error:
            problems.append(f"{Path(str(error.filename)).name} is missing")
        except (OSError, ValueError) as error:
            problems.append(str(error))
        else:
            if pointer.plan_digest != plan_digest:
                run, other = folder.parent.as_posix(), "another plan"
                raise CompileError(Diagnostic.of("RUN704", path=run, other=other))
            if problems:  # the damaged one must not become `previous` with the next save
                replace_file(folder / LAST, (folder / name).read_bytes())
            return Checkpoint(folder, pointer, problems[0] if problems else None)
    raise CompileError(
        Diagnostic.of("RUN701", path=folder.parent.as_posix(), problem="; ".join(problems))
    )


def _is_of_another_version(pointer: bytes) -> bool:
    """Whether this is a whole pointer, but not of the kind that is written here."""
    try:
        read = json.loads(pointer)
    except ValueError:
        return False
    whole = isinstance(read, dict) and "plan_digest" in read
    return whole and read.get("schema_version") != SCHEMA_VERSION


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


def not_written(folder: Path, error: OSError) -> CompileError:
    """RUN703: the disk is full, or the folder cannot be written."""
    help, problem = "free some space and go on with --resume", error.strerror or str(error)
    return CompileError(
        Diagnostic.of("RUN703", help=help, path=folder.as_posix(), problem=problem.lower())
    )


def _copy(tensor: Tensor) -> Tensor:
    """Its values now, on their own, for whoever reads them while training goes on."""
    return tensor.detach().to("cpu", copy=True, memory_format=torch.contiguous_format)


def _nothing(rings: Mapping[str, Ring]) -> Written:
    return {name: [0] * len(ring.written) for name, ring in rings.items()}


def _worth_keeping(parts: Sequence[Rows], rings: Mapping[str, Ring]) -> tuple[Rows, ...]:
    """The parts to add to, none if most of what they hold has been overwritten since."""
    marks = [_nothing(rings), *(part.written for part in parts)]
    now = {name: ring.written.tolist() for name, ring in rings.items()}
    kept = sum(_size(rings, *pair) for pair in pairwise([*marks, now]))
    return tuple(parts) if kept <= WASTE * _size(rings, marks[0], now) else ()


def _size(rings: Mapping[str, Ring], before: Written, after: Written) -> int:
    """How many numbers the rows written between two moments are."""
    return sum(
        int(ring.held(torch.tensor(before[name]), torch.tensor(after[name])).sum())
        * ring.rows.shape[2]
        for name, ring in rings.items()
    )


def _write_tensors(folder: Path, stem: str, tensors: State) -> File:
    """Write one file; its name has part of its digest, so that no other content takes its place."""
    data = save(tensors)
    digest = hashlib.sha256(data).hexdigest()
    name = f"{stem}.{digest[:8]}.safetensors"
    replace_file(folder / name, data)
    return File(name=name, sha256=digest)


def _prune(folder: Path) -> None:
    """Remove what no pointer names, and what a killed writer left half done."""
    kept = set()
    for name in (LAST, PREVIOUS):
        with contextlib.suppress(OSError, ValueError):
            kept |= {file.name for file in _files((folder / name).read_bytes())}
    for path in [*folder.glob("[0-9]*.safetensors"), *folder.glob(".*.tmp")]:
        if path.name not in kept:
            path.unlink(missing_ok=True)


def _files(pointer: bytes) -> Iterator[File]:
    read = Pointer.model_validate_json(pointer)
    yield read.state
    yield from read.rows
