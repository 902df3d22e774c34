"""The process of one job: `tiloilc`, tied to who started it and alone in its folder.

    python -m tiloilc.sweep.child FOLDER ARGUMENT…

runs `tiloilc ARGUMENT…` in FOLDER. Its standard input is a pipe on which nothing is ever written:
when the other end is closed, or whoever holds it is killed, the program interrupts itself, as by
Ctrl-C, and so leaves a checkpoint. No sweep that was killed goes on behind the back of the next.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys
import threading
import time
from pathlib import Path

from tiloilc.evaluate.alone import alone
from tiloilc.sweep.work import RECORDS, RUNS

GRACE = 120.0
"""Seconds for a last checkpoint, after which the process ends whatever it does."""


def main(folder: Path, arguments: list[str]) -> None:
    """Do the job, or go on with it, unless another process has done it meanwhile."""
    if hasattr(signal, "pthread_sigmask"):  # a parent's mask is inherited; workers of Ray have one
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM})
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with alone(folder / "lock"):
        if (folder / RECORDS).is_file():
            return
        resume = ["--resume"] if any((folder / RUNS).glob("*/*/plan.json")) else []
        sys.argv = ["tiloilc", *arguments, *resume]
        runpy.run_module("tiloilc", run_name="__main__")


def _end_with_parent() -> None:
    while os.read(0, 1):
        continue
    if hasattr(signal, "pthread_kill"):  # the main thread may wait in the system
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:  # pragma: no cover - Windows
        signal.raise_signal(signal.SIGINT)
    time.sleep(GRACE)
    os._exit(130)


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]), sys.argv[2:])
    except KeyboardInterrupt:
        sys.exit(130)
