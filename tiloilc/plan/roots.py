"""Python that belongs to a task: own environments in the task file's folder."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def importable(root: str | Path) -> Iterator[None]:
    """While this lasts, modules in the folder `root` can be imported (`module:Id-v0`).

    It is the last place that is looked in, so that no file there hides an installed package.
    """
    folder = str(Path(root).resolve())
    added = folder not in sys.path
    if added:
        sys.path.append(folder)
    try:
        yield
    finally:
        if added:
            sys.path.remove(folder)
