"""A line on standard error that is written over as work goes on."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Self

from tiloilc.cli.console import coloured


class MovingLine:
    """Lines that stay, and below them one that moves, where the terminal can do that.

    After it, as a context manager, what is written next begins in a line of its own.
    """

    def __init__(self, quiet: bool) -> None:
        self.quiet = quiet
        self.moves = not quiet and coloured(sys.stderr)
        self.width = 0

    def write(self, line: str, keep: bool) -> None:
        """Write over the moving line, if there is one."""
        if self.quiet:
            return
        start = "\r" + " " * self.width + "\r" if self.width else ""
        sys.stderr.write(start + line + ("\n" if keep else ""))
        sys.stderr.flush()
        self.width = 0 if keep else len(line)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        if self.width:
            self.write("", keep=True)


def clock(seconds: float) -> str:
    """Minutes and seconds, and hours where there are any."""
    minutes, rest = divmod(round(seconds), 60)
    hours = f"{minutes // 60}:{minutes % 60:02d}" if minutes >= 60 else str(minutes)
    return f"{hours}:{rest:02d}"
