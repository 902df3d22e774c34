"""TensorBoard beside the event log, where it is installed. Nothing is read back from it."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType

import numpy as np

FOLDER = "tensorboard"


class Board:
    """Means over seeds of metrics and losses; does nothing without the package `tensorboard`."""

    def __init__(self, run: Path, resumed_at: int | None) -> None:
        self._writer = None
        if find_spec("tensorboard") is not None:
            from torch.utils.tensorboard import SummaryWriter

            self._writer = SummaryWriter(str(run / FOLDER), purge_step=resumed_at)

    def write(self, group: str, values: Mapping[str, object], step: int) -> None:
        """Add the mean over seeds of each list in `values`; what no seed has is left out."""
        if self._writer is None:
            return
        for name, value in values.items():
            if isinstance(value, Mapping):
                self.write(f"{group}/{name}", value, step)
            elif isinstance(value, list) and not any(isinstance(v, list) for v in value):
                known = [float(v) for v in value if v is not None]
                if known:
                    self._writer.add_scalar(f"{group}/{name}", np.mean(known), step)

    def __enter__(self) -> Board:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        if self._writer is not None:
            self._writer.close()
