"""The event log: one JSON object a line, the truth of what happened, without wall-clock values."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.learn.run.checkpoint import not_written


class Events:
    """Appends to `events.jsonl`; `keep` bytes of an earlier log are kept, the rest is cut off."""

    def __init__(self, path: Path, keep: int = 0) -> None:
        self._file = path.open("r+b" if keep else "wb")
        self._file.truncate(keep)
        self._file.seek(keep)

    def write(self, kind: str, step: int, **fields: object) -> None:
        """Add one event."""
        line = json.dumps({"type": kind, "step": step, **fields}, separators=(",", ":"))
        try:
            self._file.write(line.encode() + b"\n")
            self._file.flush()
        except OSError as error:
            raise not_written(Path(self._file.name).parent, error) from None

    def size(self) -> int:
        """Bytes written so far: where to cut when resuming from now, once `sync` was called."""
        return self._file.tell()

    def sync(self) -> None:
        """All that is written is on the disk when this returns; any thread may call it."""
        os.fsync(self._file.fileno())

    def __enter__(self) -> Events:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        with contextlib.suppress(OSError):  # what could not be written has been said
            self._file.close()


def last_events(path: Path, kind: str) -> list[Mapping[str, object]]:
    """All events of one type, in order. Raises CompileError RUN701 if the log cannot be read."""
    try:
        with path.open(encoding="utf-8") as file:
            events = [json.loads(line) for line in file]
        return [event for event in events if event["type"] == kind]
    except (OSError, ValueError, KeyError, TypeError):
        there = "is damaged" if path.is_file() else "is missing"
        problem = f"{path.name} {there}"
        run = path.parent.as_posix()
        raise CompileError(Diagnostic.of("RUN701", path=run, problem=problem)) from None
