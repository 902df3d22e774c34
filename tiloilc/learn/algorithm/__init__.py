"""What transitions are worth: TiLoIL, and others, behind one protocol."""

from tiloilc.learn.algorithm.method import Method, Plain, Setup

__all__ = ["Method", "Plain", "Setup"]
