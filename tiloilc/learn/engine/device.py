"""Where a run computes, and whether its memory suffices there."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import torch

from tiloilc.diag import CompileError, Diagnostic
from tiloilc.spec.settings import Settings

NUMBER = 4
"""Bytes of a float32."""

KEPT = 6
"""Numbers kept for each parameter: itself, its slope, two moments, its target, its checkpoint."""


def pick_device(wanted: str) -> torch.device:
    """The device of `train.device`; auto: CUDA if there is one.

    Raises CompileError RUN710 if CUDA is wanted and not there.
    """
    there = torch.cuda.is_available()
    if wanted == "cuda" and not there:
        why = "torch sees no GPU" if torch.backends.cuda.is_built() else "torch is built without it"
        raise CompileError(Diagnostic.of("RUN710", problem=why, help="train with `--device auto`"))
    return torch.device("cuda" if wanted != "cpu" and there else "cpu")


@dataclass(frozen=True, slots=True)
class Memory:
    """Bytes that a run takes at most: transitions, states of stages, networks, and what a
    checkpoint copies. `row` is what one transition of every seed takes.
    """

    replay: int
    stages: int
    networks: int
    checkpoint: int
    row: int

    @property
    def total(self) -> int:
        """All of them."""
        return self.replay + self.stages + self.networks + self.checkpoint


def memory_of(
    settings: Settings, row: int, observation: int, buffers: int, networks: Sequence[Sequence[int]]
) -> Memory:
    """What a run takes, given the numbers in a transition, in an observation, the number of stage
    buffers, and for each stack of networks its height and its layers' widths.
    """
    s = settings
    capacity = min(s.buffer_size, s.steps)
    kept = min(s.stage_buffer_size, capacity)
    new = min(s.checkpoint_every, capacity)
    parameters = sum(
        stack * (inputs + 1) * outputs
        for stack, *sizes in networks
        for inputs, outputs in pairwise(sizes)
    )
    each = s.seeds * NUMBER
    return Memory(
        each * capacity * row,
        each * kept * buffers * observation,
        NUMBER * KEPT * parameters,
        each * new * (row + observation),
        each * row,
    )


def check_memory(memory: Memory, device: torch.device, settings: Settings) -> None:
    """Raises CompileError RUN709 if there is less than a run takes, with what would fit."""
    available = available_memory(device)
    if available is None or memory.total <= available:
        return
    rows = (available - memory.total + memory.replay) // memory.row
    fitting = 10 ** (len(str(rows)) - 1) if rows > 0 else 0
    fitting *= rows // fitting if fitting else 0
    enough = fitting >= 10 * settings.batch_size
    help = f"set `buffer_size: {fitting:_}`" if enough else "train fewer seeds at a time"
    needed, there = (f"{bytes / 1e9:.2g} GB" for bytes in (memory.total, available))
    raise CompileError(Diagnostic.of("RUN709", needed=needed, available=there, help=help))


def available_memory(device: torch.device) -> int | None:
    """Bytes that can still be had on `device`; None where the system does not say."""
    if device.type == "cuda":
        return int(torch.cuda.mem_get_info(device)[0])
    return min(_limits(), default=None)


def _limits() -> Iterator[int]:
    """What the machine has left, and what the group of this process may still take."""
    with suppress(OSError, ValueError, IndexError):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        yield next(1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvail"))
    with suppress(OSError, ValueError):
        group = Path("/sys/fs/cgroup")
        most = int((group / "memory.max").read_text(encoding="ascii"))
        yield most - int((group / "memory.current").read_text(encoding="ascii"))
    if not Path("/proc/meminfo").is_file():
        with suppress(OSError, ValueError, AttributeError):
            yield os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
