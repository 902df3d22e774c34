"""The command line: one file a verb, each imported only when it is called."""

from tiloilc.cli.app import main

__all__ = ["main"]
