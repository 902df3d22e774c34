"""The command line: one file a verb, each imported only when it is called."""

import sys
from collections.abc import Sequence
from typing import NoReturn

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit; 130 if interrupted, from the first moment on."""
    try:
        from tiloilc.cli.app import main as run

        run(arguments)
    except KeyboardInterrupt:
        sys.exit(130)
