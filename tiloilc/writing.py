"""Writing a file in one step, so that nobody ever reads half of it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path


def write_file(path: Path, data: str | bytes, *, sync: bool = False) -> None:
    """Write `path` under a temporary name beside it and rename: it is whole, or as it was.

    Text is written as UTF-8. With `sync` the content is on the disk before the name is. Raises
    OSError, which names `path` whatever failed.
    """
    try:
        _replace(path, data.encode() if isinstance(data, str) else data, sync)
    except OSError as error:  # it names the temporary file, which means nothing to the user
        raise OSError(error.errno, error.strerror, str(path)) from error


def _replace(path: Path, data: bytes, sync: bool) -> None:
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            if sync:
                file.flush()
                os.fsync(file.fileno())
        mask = os.umask(0o22)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
