"""The event log: one JSON object a line, the truth of what happened, without wall-clock values."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from tiloilc.diag import CompileError, Diagnostic


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
            path, problem = Path(self._file.name), (error.strerror or str(error)).lower()
            help = "free some space and go on with --resume"
            raise CompileError(
                Diagnostic.of("RUN703", path=path.parent.as_posix(), problem=problem, help=help)
            ) from None

    def size(self) -> int:
        """Bytes written so far, all of them on the disk: where to cut when resuming from now."""
        os.fsync(self._file.fileno())
        return self._file.tell()

    def __enter__(self) -> Events:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
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
