"""The one place where Graphviz is called, and kept from talking of fonts."""

from __future__ import annotations

import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

STANDARD_ERROR = 2

CHATTER = b"Fontconfig warning:"
"""How lines begin that are about the machine's fonts, which a user takes for an error of ours."""

Format = Literal["svg", "png", "json0"]

Engine = Literal["dot", "nop2"]
"""`dot` lays out; `nop2` draws what says itself where it stands."""

_one_at_a_time = threading.Lock()


def rendered(dot: str, format: Format, engine: Engine = "dot") -> bytes:
    """DOT text laid out by Graphviz and written as `format`. Raises ValueError if it cannot be."""
    import pygraphviz

    graph = pygraphviz.AGraph(string=dot)
    try:
        with _without_chatter():
            drawn = graph.draw(format=format, prog=engine)
    finally:
        graph.close()
    assert isinstance(drawn, bytes)
    return drawn


@contextmanager
def _without_chatter() -> Iterator[None]:
    """While this lasts, standard error of the whole process is held back; then all but chatter.

    Native code writes to the file descriptor, not to `sys.stderr`.
    """
    with _one_at_a_time, tempfile.TemporaryFile() as held:
        if sys.stderr is not None:
            sys.stderr.flush()
        try:
            before = os.dup(STANDARD_ERROR)
        except OSError:  # closed: nothing can be said there anyway
            yield
            return
        try:
            os.dup2(held.fileno(), STANDARD_ERROR)
            yield
        finally:
            os.dup2(before, STANDARD_ERROR)
            os.close(before)
            held.seek(0)
            kept = b"".join(line for line in held if not line.startswith(CHATTER))
            if kept:
                os.write(STANDARD_ERROR, kept)
